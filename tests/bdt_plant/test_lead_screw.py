"""The play operator against eq. 6 of the paper, integrated literally, and against figure 2."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.lead_screw import LeadScrewParameters, play

FORTY_DEGREES = math.radians(40.0)

angles = st.floats(-1e3, 1e3)
gaps = st.floats(0.0, 10.0)
paths = st.lists(angles, min_size=1, max_size=30)


def follow(path, gap, theta_d=0.0):
    """Return the angles of the screw while the motor visits the angles of `path`."""
    screw = []
    for theta_m in path:
        theta_d = play(theta_d, theta_m, gap)
        screw.append(theta_d)
    return np.array(screw)


def integrate_eq_6(motor, gap):
    """Integrate eq. 6 as it is printed, with Euler steps from sample to sample of `motor`."""
    theta_d, screw = 0.0, [0.0]
    for before, after in pairwise(motor.tolist()):
        difference = before - theta_d
        speed = after - before  # times the time step
        in_contact = (speed > 0 and difference >= gap / 2) or (speed < 0 and difference <= -gap / 2)
        theta_d += speed if in_contact else 0.0
        screw.append(theta_d)
    return np.array(screw)


def figure_2(step):
    """Return the input of figure 2, an angle whose amplitude grows from 1 to 1.5 rad."""
    times = np.arange(0.0, 5.0, step)
    return (1 + times / 10) * np.sin(2 * np.pi * times)


def test_the_screw_of_figure_2_is_that_of_eq_6_integrated_with_tiny_steps():
    step = 1e-5
    motor = figure_2(step)
    # Euler notices a contact up to one step late: 1.5 rad times 2 pi rad/s times the step.
    error = np.abs(follow(motor, FORTY_DEGREES) - integrate_eq_6(motor, FORTY_DEGREES)).max()
    assert error < 1.5 * 2 * math.pi * step


def test_the_lost_motion_of_figure_2_is_the_gap():
    motor = figure_2(1e-4)
    screw = follow(motor, FORTY_DEGREES)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(motor)))) + 1
    assert turns.size == 10
    for turn in turns:
        leaves = turn + np.flatnonzero(screw[turn:] != screw[turn])[0]
        # The screw leaves within one step of at most 1e-3 rad after the gap is closed.
        assert abs(motor[leaves] - motor[turn]) == pytest.approx(FORTY_DEGREES, abs=1e-3)


def test_the_peaks_of_figure_2_are_lower_by_half_a_gap():
    motor = figure_2(1e-4)
    screw = follow(motor, FORTY_DEGREES)
    assert screw.max() == pytest.approx(motor.max() - FORTY_DEGREES / 2, abs=1e-15)
    assert screw.min() == pytest.approx(motor.min() + FORTY_DEGREES / 2, abs=1e-15)


@given(paths, gaps, angles)
def test_the_play_operator_keeps_the_screw_within_half_a_gap(path, gap, start):
    difference = np.array(path) - follow(path, gap, start)
    # One rounding of an angle of up to 1000 rad.
    assert (np.abs(difference) <= gap / 2 + 2e-13).all()


@given(angles, angles, gaps)
def test_applying_it_twice_is_applying_it_once(theta_d, theta_m, gap):
    once = play(theta_d, theta_m, gap)
    assert play(once, theta_m, gap) == once


@given(paths, gaps, st.integers(2, 5))
def test_the_screw_depends_on_the_way_of_the_motor_and_not_on_its_speed(path, gap, pieces):
    slow = [0.0]
    for target in path:
        slow.extend(np.linspace(slow[-1], target, pieces + 1)[1:-1].tolist())
        slow.append(target)
    at_targets = follow(slow, gap)[pieces::pieces]
    assert (at_targets == follow(path, gap)).all()


@given(paths, gaps, angles)
def test_turning_all_signs_turns_the_screw_exactly(path, gap, start):
    turned = follow([-theta for theta in path], gap, -start)
    assert (follow(path, gap, start) == -turned).all()


@given(paths, gaps)
def test_the_backlash_takes_energy_for_every_way_of_the_screw_and_never_gives_any(path, gap):
    """With a spring between motor and screw, half a gap of its stretch is lost all the way."""
    screw = follow(path, gap)
    ways = np.diff(screw, prepend=0.0)
    lost = (np.array(path) - screw) * ways
    assert lost == pytest.approx(gap / 2 * np.abs(ways), abs=1e-9)


@given(paths)
def test_without_a_gap_the_screw_is_the_motor(path):
    assert follow(path, 0.0).tolist() == path


@given(angles, st.floats(-1, 1), gaps, gaps)
def test_a_growing_gap_leaves_the_screw_where_it_is(theta_m, where, gap, growth):
    theta_d = play(theta_m + where * gap / 2, theta_m, gap)
    assert play(theta_d, theta_m, gap + growth) == theta_d


@pytest.mark.parametrize(("theta_d", "pushed_to"), [(0.9, 0.25), (-0.9, -0.25), (0.1, 0.1)])
def test_a_shrinking_gap_takes_the_screw_along(theta_d, pushed_to):
    assert play(theta_d, 0.0, 0.5) == pushed_to


def test_the_default_pitch_is_one_millimeter_a_turn():
    assert LeadScrewParameters().pitch * 2 * math.pi == pytest.approx(1e-3, rel=1e-15)


@pytest.mark.parametrize("pitch", [0.0, -1.0, float("nan"), float("inf"), "1", False])
def test_a_pitch_that_no_screw_has_is_refused(pitch):
    with pytest.raises(ValueError, match=r"LeadScrewParameters\.pitch = .*must be .* m/rad"):
        LeadScrewParameters(pitch=pitch)
