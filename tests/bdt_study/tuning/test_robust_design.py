"""Designs for the worst of many mechanisms, beside python-control and the default gains."""

import pytest

from bdt_controller.notch import NotchFilter
from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel
from bdt_study.design.tuned_gains import INTEGRAL_TIME, TUNED_GAINS
from bdt_study.tuning.linear_judgment import judge
from bdt_study.tuning.mechanism_ranges import MechanismRanges, corners
from bdt_study.tuning.robust_design import ControllerDesign, RobustSearch

MODELS = corners(PlantModel(), MechanismRanges())
RATE = 500.0


@pytest.fixture(scope="module")
def search():
    return RobustSearch(MODELS, 10.0, RATE)


@pytest.mark.parametrize(
    ("gains", "notch"),
    [
        (PidGains(), NotchFilter()),
        (PidGains(1862.7, 18627.0, 1287.8, 0.17286), NotchFilter(27.07, 0.05, 1.2)),
    ],
)
def test_the_search_sees_the_sensitivities_that_python_control_sees(search, gains, notch):
    design = ControllerDesign("", gains, notch)
    judged = judge(design, MODELS, RATE)
    assert judged.stable
    seen = search.sensitivities(design)
    assert seen[0] == pytest.approx(judged.nominal_sensitivity, rel=5e-3)
    assert seen.max() == pytest.approx(judged.largest_sensitivity, rel=5e-3)


def test_the_default_gains_are_as_sensitive_as_the_issue_says():
    judged = judge(ControllerDesign("", PidGains()), MODELS, RATE)
    assert judged.largest_sensitivity == pytest.approx(5.1, abs=0.05)


@pytest.fixture(scope="module")
def slower(search):
    return search.design("slower", INTEGRAL_TIME, with_notch=False)


def test_a_slower_integral_makes_a_pid_that_bears_the_harsh_mechanism(slower):
    judged = judge(slower, MODELS, RATE)
    assert judged.stable
    assert judged.integrates
    assert judged.bandwidth == pytest.approx(10.0, rel=0.01)
    assert judged.largest_sensitivity < 3.7


def test_a_filter_at_the_first_mode_bears_much_more(search):
    design = search.design("notch", 0.1, with_notch=True)
    assert design.notch.frequency == pytest.approx(27.07, rel=1e-3)
    judged = judge(design, MODELS, RATE)
    assert judged.stable
    assert judged.bandwidth == pytest.approx(10.0, rel=0.02)
    assert judged.largest_sensitivity < 2.2


def test_the_tuned_gains_are_what_the_design_finds(slower):
    found, stated = (tuple(vars(one).values()) for one in (slower.gains, TUNED_GAINS.pid))
    assert found == pytest.approx(stated, rel=0.01)
