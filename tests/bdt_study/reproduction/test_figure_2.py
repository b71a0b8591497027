"""Figure 2: lost motion, read off the curves."""

import math

import numpy as np
import pytest

from bdt_study.reproduction.figure_2 import (
    BacklashResponse,
    backlash_response,
    figure_2,
    lost_motion_equals_gap,
    lost_motions,
)


@pytest.fixture(scope="module")
def response():
    return backlash_response()


def test_the_motor_follows_the_formula_of_the_paper(response):
    assert response.theta_m[1250] == pytest.approx((1 + 0.025) * math.sin(2 * math.pi * 0.25))


def test_the_screw_turns_back_half_a_gap_before_the_motor_does(response):
    """At its turning points the screw lags the motor's by half a gap, whatever the amplitude."""
    for period in range(1, 10):
        shown = slice(period * 5000, (period + 1) * 5000)
        lag = response.theta_m[shown].max() - response.theta_d[shown].max()
        assert lag == pytest.approx(math.radians(20.0), abs=1e-12)


def test_the_lost_motion_is_the_gap(response):
    assert np.rad2deg(lost_motions(response)) == pytest.approx([40.0] * 9, abs=1e-9)
    assert lost_motion_equals_gap(response).holds


def test_a_backlash_of_half_the_gap_is_noticed(response):
    between = 0.5 * (response.theta_d + response.theta_m)
    claim = lost_motion_equals_gap(BacklashResponse(response.t, response.theta_m, between))
    assert not claim.holds


def test_the_figure_has_both_parts(response):
    over_time, loops = figure_2(response).axes
    assert over_time.get_xlabel() == "time t [s]"
    assert loops.get_ylabel() == "lead screw $θ_d$ [deg]"
