"""Width of the dead zone: too narrow fails, too wide costs bias, the right one does neither."""

import pytest

from bdt_study.engine.in_this_process import InThisProcess
from bdt_study.reproduction.dead_zone_sweep import sweep_tolerances, tolerance_figure
from bdt_study.reproduction.experiments import Choices


@pytest.fixture(scope="module")
def outcomes():
    return sweep_tolerances(InThisProcess(), Choices(), (0.0, 1.0, 4.0))


def test_too_narrow_fails_and_too_wide_costs_bias(outcomes):
    narrow, right, wide = outcomes
    assert narrow.limit_cycles == 6
    assert right.limit_cycles == 0
    assert wide.limit_cycles == 0
    assert right.residual < 5e-6
    assert narrow.residual > 100e-6
    assert wide.bias > 3 * right.bias


def test_the_bias_is_no_larger_than_the_dead_zone(outcomes):
    for outcome in outcomes[1:]:
        tolerance = outcome.ratio * 20.0 / 360.0 * 1e-3
        assert outcome.bias <= 100 * tolerance / 0.005


def test_the_figure_has_three_panels(outcomes):
    assert len(tolerance_figure(outcomes).axes) == 3
