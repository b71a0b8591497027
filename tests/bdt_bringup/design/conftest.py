"""The design of the default gains, found once for all tests of this folder."""

import pytest

from bdt_bringup.design.pid_design import PidDesign, design_pid
from bdt_plant.plant import PlantModel


@pytest.fixture(scope="package")
def design() -> PidDesign:
    return design_pid(PlantModel())
