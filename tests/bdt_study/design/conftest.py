"""The design of the default gains, found once for all tests of this folder."""

import pytest

from bdt_plant.plant import PlantModel
from bdt_study.design.pid_design import PidDesign, design_pid


@pytest.fixture(scope="package")
def design() -> PidDesign:
    return design_pid(PlantModel())
