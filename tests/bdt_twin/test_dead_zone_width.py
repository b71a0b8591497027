"""Eq. 9: the dead zone for an estimated gap."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.dead_zone_width import tolerance_for_gap

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
