"""Friction that yields: against closed forms, and a solution of the motor's equations."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from bdt_plant.motor import MotorParameters, MotorState
from bdt_plant.resisted_motor import discretize_resisted_motor, resisted_motor_step
from bdt_twin.yielding_friction import (
    SLIDING,
    bend_after,
    held_bend,
    way_left,
    yielding_motor_step,
)

ANGLE = math.radians(0.4)
MOTOR = MotorParameters()
FRICTION = 0.01
SIZE = FRICTION / MOTOR.torque_constant
FRICTION_VOLTAGE = SIZE * MOTOR.resistance
NOTHING = 0.0, 0.0, 0.0


def bent(bend, turned, yield_angle):
    return bend_after(bend, turned, way_left(turned, yield_angle))


angles = st.floats(-0.2, 0.2)
bends = st.floats(-1.0, 1.0)


@pytest.mark.parametrize("degrees", [0.02, 0.2, 1.0])
def test_after_a_reversal_friction_follows_dahls_curve(degrees):
    angle = math.radians(degrees)
    for turned in np.linspace(0.0, 9.0 * angle, 500):
        dahl = 1.0 - 2.0 * math.exp(-turned / angle)
        assert bent(-1.0, turned, angle) == pytest.approx(dahl, abs=1e-14)


@given(bends, st.lists(st.floats(0.0, 0.05), min_size=1, max_size=20), st.sampled_from([-1, 1]))
def test_it_depends_on_how_far_the_motor_has_turned_and_not_in_how_many_steps(bend, turns, side):
    at_once = bent(bend, side * sum(turns), ANGLE)
    for turned in turns:
        bend = bent(bend, side * turned, ANGLE)
    assert bend == pytest.approx(at_once, abs=2.0 * (1.0 - SLIDING))


@given(bends, angles)
def test_it_pulls_against_the_motion_and_never_more_than_friction(bend, turned):
    after = bent(bend, turned, ANGLE)
    assert abs(after) <= 1.0
    assert (after - bend) * turned >= -1e-15


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_motor_that_has_turned_far_slides_with_coulombs_friction(side):
    assert bent(0.0, side * 10.0 * ANGLE, ANGLE) == side
    assert bent(side, side * 1e-6, ANGLE) == side
    assert held_bend(side, side * 1e-3, 1e-3, ANGLE) == side
    assert abs(bent(side, -side * 1e-6, ANGLE)) < 1.0


@given(bends, angles, st.floats(1e-5, 1.0))
def test_what_is_held_over_a_step_is_between_its_ends_and_turns_the_motor_as_far(
    bend, free, per_friction
):
    held = held_bend(bend, free, per_friction, ANGLE)
    turned = free - per_friction * (held - bend)
    after = bent(bend, turned, ANGLE)
    assert turned * free >= -1e-12, "asperities stop a motor, and turn none back"
    assert min(bend, after) - 1e-4 <= held <= max(bend, after) + 1e-4
    # At least half of what has changed by the end is felt in the mean: that is stable.
    assert abs(held - bend) >= 0.5 * abs(after - bend) - 1e-4


def test_soft_asperities_pull_in_the_mean_and_stiff_ones_as_they_do_in_the_end():
    free = 0.1 * ANGLE
    for per_friction, weight in ((1e-6 * ANGLE, 0.5), (1e3 * ANGLE, 1.0)):
        held = held_bend(0.0, free, per_friction, ANGLE)
        after = bent(0.0, free - per_friction * held, ANGLE)
        assert held / after == pytest.approx(weight, rel=0.01)


def motion(voltages, angle, step_time):
    """Return the motor's angle after each step."""
    step, motor = discretize_resisted_motor(MOTOR, step_time), MotorState(0, 0, 0)
    bend, found = 0.0, []
    for voltage in voltages:
        before = motor.angle
        if angle > 0.0:
            motor = yielding_motor_step(motor, voltage, NOTHING, SIZE, bend, angle, step)
            bend = bent(bend, motor.angle - before, angle)
        else:
            motor = resisted_motor_step(motor, voltage, 0.0, SIZE, SIZE, step)
        found.append(motor.angle)
    return np.array(found)


def solution(voltage, times):
    """Return the angle of a motor with friction that yields, from its differential equations."""

    def slopes(time, state):
        current, speed, _, bend = state
        torque = MOTOR.torque_constant * current - FRICTION * bend
        return [
            (voltage(time) - MOTOR.resistance * current - MOTOR.back_emf_constant * speed)
            / MOTOR.inductance,
            torque / MOTOR.inertia,
            speed,
            (speed - bend * abs(speed)) / ANGLE,
        ]

    run = solve_ivp(slopes, (0.0, times[-1]), np.zeros(4), "LSODA", times, max_step=2e-5, rtol=1e-8)
    return run.y[2]


@pytest.mark.parametrize(("step_time", "share"), [(1e-4, 0.01), (1e-3, 0.08)])
def test_the_motor_moves_as_its_differential_equations_have_it(step_time, share):
    times = np.arange(1, round(0.3 / step_time) + 1) * step_time
    # Slower than the friction's voltage and faster, to and fro.

    def voltage(time):
        return 3.0 * FRICTION_VOLTAGE * math.sin(40.0 * time) * math.sin(11.0 * time)

    held = [voltage(time - 0.5 * step_time) for time in times]
    expected = solution(
        lambda time: held[min(int(time / step_time * (1.0 + 1e-9)), len(held) - 1)], times
    )
    yielded = np.abs(motion(held, 0.0, step_time) - expected).max()
    assert yielded > math.radians(0.3)
    assert np.abs(motion(held, ANGLE, step_time) - expected).max() < share * yielded


@pytest.mark.parametrize("step_time", [2e-4, 1e-3, 1e-2])
@pytest.mark.parametrize(("angle", "beyond"), [(3e-4, 0.25), (ANGLE, 1e-3)])
def test_a_motor_that_yields_comes_to_rest_where_friction_holds_it_whatever_the_step(
    step_time, angle, beyond
):
    """Also where a step is long for the stiffness of the asperities.

    A motor that rings on stiff ones comes to rest beyond, for they do not take it back all the way.
    """
    found = motion([0.15 * FRICTION_VOLTAGE] * round(5.0 / step_time), angle, step_time)
    held = -angle * math.log1p(-0.15)
    assert held * (1.0 - 1e-3) < found[-1] < held * (1.0 + beyond)
    assert np.abs(np.diff(found[-50:])).max() < 1e-9
