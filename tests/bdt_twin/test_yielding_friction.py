"""Springs that slip: against a solution of the motor's equations, and against Dahl's curve."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.stats import gamma

from bdt_plant.motor import MotorParameters, MotorState
from bdt_plant.resisted_motor import discretize_resisted_motor, resisted_motor_step
from bdt_twin.yielding_friction import (
    SLIP_ANGLES,
    SPRINGS,
    bend_springs,
    elastic_share,
    held_share,
    sliding_direction,
    yielding_motor_step,
)

ANGLE = math.radians(0.4)
SLIPS_AT = ANGLE * np.array(SLIP_ANGLES)
MOTOR = MotorParameters()
FRICTION = 0.01
SIZE = FRICTION / MOTOR.torque_constant
FRICTION_VOLTAGE = SIZE * MOTOR.resistance
NOTHING = 0.0, 0.0, 0.0

angles = st.floats(-0.2, 0.2)
all_bends = st.tuples(*[st.floats(-1.0, 1.0)] * SPRINGS).map(np.array)


def test_springs_stand_for_thirds_of_a_gamma_distribution():
    """Means of a third each, by integration."""
    for number, slips_at in enumerate(SLIP_ANGLES):
        share = (np.arange(100_000) + 0.5) / 100_000
        third = gamma.ppf((number + share) / SPRINGS, 2, scale=0.5)
        assert slips_at == pytest.approx(third.mean(), abs=2e-4)


@given(st.lists(angles, min_size=1, max_size=20))
def test_a_spring_follows_the_motor_up_to_its_angle(turns):
    bends = np.zeros(SPRINGS)
    for turned in turns:
        expected = np.clip(bends + turned / SLIPS_AT, -1.0, 1.0)
        bend_springs(bends, turned, ANGLE)
        assert bends == pytest.approx(expected)


@given(all_bends, angles)
def test_springs_pull_with_their_mean_bend_and_never_more_than_friction(bends, turned):
    expected = np.clip(bends + turned / SLIPS_AT, -1.0, 1.0).mean()
    assert elastic_share(bends, turned, ANGLE) == pytest.approx(expected)
    assert abs(elastic_share(bends, turned, ANGLE)) <= 1.0


def test_springs_that_all_slip_are_coulombs_friction():
    for direction in (-1.0, 1.0):
        bends = direction * np.ones(SPRINGS)
        assert sliding_direction(bends) == direction
        assert elastic_share(bends, direction * 1e-6, ANGLE) == pytest.approx(direction)
    assert sliding_direction(np.array([1.0, 1.0, 0.9])) == 0.0


@given(all_bends, angles, st.floats(1e-5, 1.0))
def test_what_is_held_over_a_step_is_between_its_ends_and_turns_the_motor_as_far(
    bends, free, per_friction
):
    before = elastic_share(bends, 0.0, ANGLE)
    held = held_share(bends, free, per_friction, ANGLE)
    turned = free - per_friction * (held - before)
    after = elastic_share(bends, turned, ANGLE)
    assert turned * free >= -1e-12, "springs stop a motor, and turn none back"
    assert min(before, after) - 1e-9 <= held <= max(before, after) + 1e-9
    # At least half of what has changed by the end is felt in the mean: that is stable.
    assert abs(held - before) >= 0.5 * abs(after - before) - 1e-9


def test_soft_springs_pull_in_the_mean_and_stiff_ones_as_they_do_in_the_end():
    bends, free = np.zeros(SPRINGS), 0.1 * ANGLE
    for per_friction, weight in ((1e-6 * ANGLE, 0.5), (1e3 * ANGLE, 1.0)):
        held = held_share(bends, free, per_friction, ANGLE)
        after = elastic_share(bends, free - per_friction * held, ANGLE)
        assert held / after == pytest.approx(weight, rel=0.01)


def motion(voltages, angle, step_time):
    """Return the motor's angle after each step."""
    step, motor = discretize_resisted_motor(MOTOR, step_time), MotorState(0, 0, 0)
    bends, found = np.zeros(SPRINGS), []
    for voltage in voltages:
        before = motor.angle
        if angle > 0.0:
            motor = yielding_motor_step(motor, voltage, NOTHING, SIZE, bends, angle, step)
            bend_springs(bends, motor.angle - before, angle)
        else:
            motor = resisted_motor_step(motor, voltage, 0.0, SIZE, SIZE, step)
        found.append(motor.angle)
    return np.array(found)


def solution(voltage, times):
    """Return the angle of a motor with friction that yields, from its differential equations."""

    def slopes(time, state):
        current, speed, _ = state[:3]
        bends = state[3:]
        slips = (np.abs(bends) >= 1.0) & (bends * speed > 0.0)
        torque = MOTOR.torque_constant * current - FRICTION * bends.mean()
        return [
            (voltage(time) - MOTOR.resistance * current - MOTOR.back_emf_constant * speed)
            / MOTOR.inductance,
            torque / MOTOR.inertia,
            speed,
            *np.where(slips, 0.0, speed / SLIPS_AT),
        ]

    start = np.zeros(3 + SPRINGS)
    run = solve_ivp(slopes, (0.0, times[-1]), start, "LSODA", times, max_step=2e-5, rtol=1e-8)
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
@pytest.mark.parametrize("angle", [3e-4, ANGLE])
def test_a_motor_that_yields_comes_to_rest_where_its_springs_hold_it_whatever_the_step(
    step_time, angle
):
    """Also where a step is long for the stiffness of the springs."""
    found = motion([0.15 * FRICTION_VOLTAGE] * round(5.0 / step_time), angle, step_time)
    stiffness = (1.0 / np.array(SLIP_ANGLES)).mean() / angle
    assert found[-1] == pytest.approx(0.15 / stiffness, rel=1e-6)
    assert np.abs(np.diff(found[-50:])).max() < 1e-9


@pytest.mark.parametrize("degrees", [0.02, 0.2, 1.0])
def test_springs_make_up_dahls_curve(degrees):
    """Friction after a reversal goes from -F to F as 1 - 2 exp(-turned / angle)."""
    angle = math.radians(degrees)
    for turned in np.linspace(0.0, 5.0 * angle, 500):
        dahl = 1.0 - 2.0 * math.exp(-turned / angle)
        assert elastic_share(-np.ones(SPRINGS), turned, angle) == pytest.approx(dahl, abs=0.065)
