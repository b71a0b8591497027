"""Figure 6: the estimated angle of the lead screw beside the true one."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bdt_study.reproduction.figure_6 import (
    constant_input_matches,
    figure_6,
    moving_input_differs,
    screw_angle,
)


@pytest.fixture(scope="module")
def angle(runs):
    return screw_angle(runs)


def test_the_angles_match_at_rest_and_differ_in_motion(angle):
    assert constant_input_matches(angle).measured < 0.001
    assert constant_input_matches(angle).holds
    assert moving_input_differs(angle).measured == pytest.approx(0.088, abs=0.02)
    assert moving_input_differs(angle).holds


def test_one_sample_of_misalignment_would_show(runs, angle):
    loop = runs.fixed.loop
    shifted = replace(
        runs, fixed=replace(runs.fixed, loop=replace(loop, theta_d=np.roll(loop.theta_d, -1)))
    )
    assert screw_angle(shifted).moving > math.radians(0.4)


def test_an_offset_does_not_match(angle):
    assert not constant_input_matches(angle._replace(at_rest=math.radians(0.1))).holds


def test_the_figure_has_command_output_gap_and_error(runs, angle):
    labels = [axes.get_ylabel() for axes in figure_6(runs, angle).axes]
    assert labels[:3] == ["command u [V]", "output $q_3$ [mm]", "gap [deg]"]
