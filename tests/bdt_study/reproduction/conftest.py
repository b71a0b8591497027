"""The simulations of the paper, run once for all tests of this folder."""

import pytest

from bdt_study.reproduction.experiments import Choices, run_paper


@pytest.fixture(scope="package")
def runs():
    return run_paper(Choices())
