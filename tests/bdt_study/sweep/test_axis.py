"""Axes: what a fraction of 0 to 1 means, against scipy's distributions."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from bdt_study.sweep.axis import NORMAL_REACH, Axis

AXES = {
    "uniform": (Axis("a", distribution="uniform", first=2.0, second=5.0), stats.uniform(2.0, 3.0)),
    "log_uniform": (
        Axis("a", distribution="log_uniform", first=1e-3, second=10.0),
        stats.loguniform(1e-3, 10.0),
    ),
    "normal": (
        Axis("a", distribution="normal", first=1.0, second=0.1),
        stats.truncnorm(-NORMAL_REACH, NORMAL_REACH, 1.0, 0.1),
    ),
}


@pytest.mark.parametrize("name", AXES)
@given(fraction=st.floats(0.0, 1.0))
def test_a_fraction_is_the_probability_below_its_value(name, fraction):
    axis, reference = AXES[name]
    assert axis.value_at(fraction) == pytest.approx(reference.ppf(fraction), rel=1e-9)


@pytest.mark.parametrize("name", AXES)
@given(fraction=st.floats(0.0, 1.0))
def test_no_value_lies_beyond_the_ends_that_were_checked(name, fraction):
    axis, _ = AXES[name]
    low, high = axis.extremes
    assert low <= axis.value_at(fraction) <= high


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({}, "must have values or a distribution"),
        ({"distribution": "uniform", "first": 1.0, "second": 1.0}, "must increase"),
        ({"distribution": "log_uniform", "first": 0.0, "second": 1.0}, "must be above 0"),
        ({"distribution": "normal", "first": 0.0, "second": 0.0}, "deviation must be above 0"),
        ({"distribution": "uniform", "first": 0.0, "second": math.inf}, "two finite numbers"),
        ({"distribution": "cauchy"}, "must be one of uniform, log_uniform, normal"),
    ],
)
def test_an_axis_without_a_meaning_is_refused(given, says):
    with pytest.raises(ValueError, match=says):
        Axis("plant.gap.initial", **given)
