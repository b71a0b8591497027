"""Eq. 9: the dead zone for an estimated gap."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.dead_zone_tolerance import (
    EQUATION_9,
    DeadZoneRule,
    DeadZoneSettings,
    gap_bound,
    tolerance_for_gap,
)
from bdt_twin.estimator import Estimate

PITCH = 1e-3 / (2 * math.pi)


def test_a_gap_of_ten_degrees_is_28_micrometers_of_the_screw():
    assert tolerance_for_gap(math.radians(10.0), PITCH) == pytest.approx(1e-3 / 36, rel=1e-14)


@given(st.floats(0, 10), st.floats(1e-6, 1))
def test_the_tolerance_is_pitch_times_gap(gap, pitch):
    assert tolerance_for_gap(gap, pitch) == pitch * gap


@given(st.floats(-10, 0))
def test_an_estimate_below_zero_switches_the_dead_zone_off(gap):
    """The controller refuses a negative tolerance; noise can make an estimate negative."""
    assert tolerance_for_gap(gap, PITCH) == 0.0


ESTIMATE = Estimate(time=10.0, gap=0.2, uncertainty=0.01, growth=0.005)


def test_the_bound_of_a_gap_grows_with_time_and_with_doubt():
    assert gap_bound(ESTIMATE, 10.0, 0.0) == 0.2
    assert gap_bound(ESTIMATE, 14.0, 0.0) == pytest.approx(0.2 + 4 * 0.005)
    assert gap_bound(ESTIMATE, 14.0, 2.0) == pytest.approx(0.2 + 4 * 0.005 + 2 * 0.01)
    unsteady = ESTIMATE._replace(growth_uncertainty=0.003)
    assert gap_bound(unsteady, 10.0, 2.0) == pytest.approx(0.2 + 2 * 0.01)
    # Independent doubts of gap and growth: a triangle of 0.009, 0.012 and 0.015.
    doubtful = unsteady._replace(uncertainty=0.009)
    assert gap_bound(doubtful, 14.0, 2.0) == pytest.approx(0.2 + 4 * 0.005 + 2 * 0.015)


def test_a_gap_does_not_heal():
    assert gap_bound(ESTIMATE._replace(growth=-0.1), 14.0, 0.0) == 0.2
    assert gap_bound(ESTIMATE, 6.0, 0.0) == 0.2


@pytest.mark.parametrize("uncertainty", [math.nan, math.inf])
def test_doubt_that_is_no_number_adds_nothing(uncertainty):
    assert gap_bound(ESTIMATE._replace(uncertainty=uncertainty), 10.0, 3.0) == 0.2


@given(st.floats(0, 1), st.floats(0, 100))
def test_by_default_the_dead_zone_is_that_of_eq_9_exactly(gap, time):
    rule = DeadZoneRule(EQUATION_9, PITCH)
    for step in range(3):
        estimate = Estimate(time + step, gap)
        assert rule.tolerance(estimate, time + step + 1.0) == PITCH * gap


def test_the_dead_zone_has_a_margin_and_holds_until_the_next_one_comes():
    rule = DeadZoneRule(DeadZoneSettings(margin=0.03, horizon=2.0), PITCH)
    expected = PITCH * (0.2 + 0.005 * (4.0 + 2.0) + 0.03)
    assert rule.tolerance(ESTIMATE, 14.0) == pytest.approx(expected)


def test_the_dead_zone_stays_within_its_range():
    rule = DeadZoneRule(DeadZoneSettings(minimum=1e-5, maximum=3e-5), PITCH)
    tolerances = [rule.tolerance(Estimate(t, gap), t) for t, gap in enumerate((0.0, 0.1, 1.0))]
    assert tolerances == [1e-5, PITCH * 0.1, 3e-5]


def test_the_dead_zone_changes_no_faster_than_its_limit_in_either_direction():
    rule = DeadZoneRule(DeadZoneSettings(rate_limit=1e-6), PITCH)
    first = rule.tolerance(Estimate(0.0, 0.1), 1.0)
    assert first == PITCH * 0.1
    assert rule.tolerance(Estimate(2.0, 1.0), 3.0) == pytest.approx(first + 2e-6)
    assert rule.tolerance(Estimate(2.5, 0.0), 3.5) == pytest.approx(first + 1.5e-6)
    rule.restart()
    assert rule.tolerance(Estimate(0.0, 1.0), 0.0) == PITCH


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"coverage_factor": -1.0}, r"coverage_factor = -1\.0: must be 0 to 10"),
        ({"minimum": 2e-5, "maximum": 1e-5}, r"minimum = 2e-05 m: must be at most maximum"),
        ({"rate_limit": 0.0}, r"rate_limit = 0\.0 m/s: must be 1e-09 to 1 m/s"),
    ],
)
def test_a_fault_is_named_with_its_value_and_what_is_allowed(fault, text):
    with pytest.raises(ValueError, match=r"^DeadZoneSettings\." + text):
        DeadZoneSettings(**fault)


@given(uncertainty=st.floats(0, 1e3), growth=st.floats(0, 10), age=st.floats(0, 1e5))
def test_a_loop_that_rests_for_however_long_is_able_to_move(uncertainty, growth, age):
    """Doubt and growth widen the dead zone by so much at most; nothing else ends a rest."""
    settings = DeadZoneSettings(coverage_factor=2.0, margin=0.02, largest_growth=0.3)
    estimate = Estimate(0.0, 0.2, uncertainty, growth)
    tolerance = DeadZoneRule(settings, PITCH).tolerance(estimate, age)
    assert tolerance <= PITCH * (0.2 + 0.3 + 0.02) * (1 + 1e-12)


def test_the_rule_tells_while_doubt_is_larger_than_what_it_may_add():
    rule = DeadZoneRule(DeadZoneSettings(coverage_factor=2.0, largest_growth=0.3), PITCH)
    assert not rule.is_bounded
    rule.tolerance(ESTIMATE._replace(uncertainty=0.2), 10.0)
    assert rule.is_bounded
    rule.tolerance(ESTIMATE, 10.0)
    assert not rule.is_bounded
    rule.tolerance(ESTIMATE, 100.0)
    assert rule.is_bounded
    rule.restart()
    assert not rule.is_bounded


def test_a_rule_goes_on_from_the_tolerance_in_force_at_its_rate():
    rule = DeadZoneRule(DeadZoneSettings(rate_limit=1e-6), PITCH)
    rule.resume(2e-5, 10.0)
    assert rule.tolerance(Estimate(12.0, 0.5), 12.0) == pytest.approx(2.2e-5)
