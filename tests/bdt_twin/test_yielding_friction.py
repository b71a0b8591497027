"""Springs that slip: against a solution of the motor's equations, and against Dahl's curve."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import nnls

from bdt_plant.motor import MotorParameters, MotorState
from bdt_plant.resisted_motor import discretize_resisted_motor, resisted_motor_step
from bdt_twin.yielding_friction import (
    RIGID,
    SPRINGS,
    YIELD_ANGLES,
    YieldingFriction,
    bend_springs,
    elastic_share,
    elastic_stiffness,
    sliding_direction,
    yielding_motor_step,
)

ANGLES = np.array(YIELD_ANGLES)
HALF = YieldingFriction((0.3, 0.0, 0.2), 0.5)
ALL = YieldingFriction((0.2, 0.5, 0.3), 0.0)
MOTOR = MotorParameters()
FRICTION = 0.01
SIZE = FRICTION / MOTOR.torque_constant
FRICTION_VOLTAGE = SIZE * MOTOR.resistance
NOTHING = 0.0, 0.0, 0.0

angles = st.floats(-0.2, 0.2)


@given(st.lists(angles, min_size=1, max_size=20))
def test_a_spring_follows_the_motor_up_to_its_angle(turns):
    bends = np.zeros(SPRINGS)
    for turned in turns:
        expected = np.clip(bends + turned, -ANGLES, ANGLES)
        bend_springs(bends, turned)
        assert (bends == expected).all()


@given(st.tuples(*[st.floats(-1.0, 1.0)] * SPRINGS), angles)
def test_springs_never_pull_more_than_friction_is(shares, turned):
    bends = ANGLES * np.array(shares)
    for friction in (RIGID, HALF, ALL):
        assert abs(elastic_share(bends, turned, friction)) <= 1.0 - friction.rigid + 1e-12


def test_springs_that_all_slip_are_coulombs_friction():
    for direction in (-1.0, 1.0):
        bends = direction * ANGLES
        assert sliding_direction(bends) == direction
        assert elastic_share(bends, direction * 1e-6, ALL) == pytest.approx(direction)
        assert elastic_stiffness(bends, direction * 1e-6, ALL) == 0.0
        assert elastic_stiffness(bends, -direction * 1e-6, ALL) > 0.0
    assert sliding_direction(ANGLES * np.array([1.0, 1.0, 0.9])) == 0.0


def test_the_stiffness_is_the_slope_of_the_torque():
    bends, change = 0.5 * ANGLES, 1e-7
    slope = (elastic_share(bends, change, HALF) - elastic_share(bends, -change, HALF)) / 2e-7
    assert elastic_stiffness(bends, 0.0, HALF) == pytest.approx(slope)


def motion(voltages, friction, step_time):
    """Return the motor's angle after each step."""
    step, motor = discretize_resisted_motor(MOTOR, step_time), MotorState(0, 0, 0)
    bends, found = np.zeros(SPRINGS), []
    for voltage in voltages:
        before = motor.angle
        motor = yielding_motor_step(motor, voltage, NOTHING, SIZE, bends, friction, step)
        bend_springs(bends, motor.angle - before)
        found.append(motor.angle)
    return np.array(found)


def solution(voltage, times):
    """Return the angle of a motor all of whose friction yields, from its differential equations."""
    shares = np.array(ALL.shares)

    def slopes(time, state):
        current, speed, _ = state[:3]
        bends = state[3:]
        slips = (np.abs(bends) >= ANGLES) & (bends * speed > 0.0)
        torque = MOTOR.torque_constant * current - FRICTION * (shares * bends / ANGLES).sum()
        return [
            (voltage(time) - MOTOR.resistance * current - MOTOR.back_emf_constant * speed)
            / MOTOR.inductance,
            torque / MOTOR.inertia,
            speed,
            *np.where(slips, 0.0, speed),
        ]

    start = np.zeros(3 + SPRINGS)
    run = solve_ivp(slopes, (0.0, times[-1]), start, "LSODA", times, max_step=2e-5, rtol=1e-8)
    return run.y[2]


def test_the_motor_moves_as_its_differential_equations_have_it():
    step_time = 1e-4
    times = np.arange(1, 3001) * step_time
    # Slower than the friction's voltage and faster, to and fro.

    def voltage(time):
        return 3.0 * FRICTION_VOLTAGE * math.sin(40.0 * time) * math.sin(11.0 * time)

    held = [voltage(time - 0.5 * step_time) for time in times]
    expected, found = solution(voltage, times), motion(held, ALL, step_time)
    rigid = motion(held, RIGID, step_time)
    yielded = np.abs(rigid - expected).max()
    assert yielded > math.radians(0.5)
    assert np.abs(found - expected).max() < 0.03 * yielded


@pytest.mark.parametrize("step_time", [2e-4, 1e-3, 1e-2])
def test_a_motor_that_yields_comes_to_rest_where_its_springs_hold_it_whatever_the_step(step_time):
    """Also where a step is long for the stiffness of the springs."""
    found = motion([0.15 * FRICTION_VOLTAGE] * round(5.0 / step_time), ALL, step_time)
    stiffness = elastic_stiffness(np.zeros(SPRINGS), 0.0, ALL)
    assert found[-1] == pytest.approx(0.15 / stiffness, rel=1e-6)
    assert np.abs(np.diff(found[-50:])).max() < 1e-9


def test_rigid_friction_is_that_of_the_resisted_motor():
    step, bends = discretize_resisted_motor(MOTOR, 2e-4), np.zeros(SPRINGS)
    for state in (
        MotorState(0.0, 0.0, 0.0),
        MotorState(0.02, 1.0, 0.3),
        MotorState(0.0, -0.1, 0.0),
    ):
        for voltage in (-1.0, 0.05, 1.0):
            assert yielding_motor_step(
                state, voltage, NOTHING, SIZE, bends, RIGID, step
            ) == resisted_motor_step(state, voltage, 0.0, SIZE, SIZE, step)


@pytest.mark.parametrize("degrees", [0.2, 0.5, 1.0])
def test_springs_and_a_rigid_rest_make_up_dahls_curve(degrees):
    """Friction after a reversal goes from -F to F as 1 - 2 exp(-turned / angle)."""
    angle = math.radians(degrees)
    turned = np.linspace(0.0, 5.0 * angle, 500)
    dahl = 1.0 - 2.0 * np.exp(-turned / angle)
    curves = np.minimum(turned[:, None] / ANGLES - 1.0, 1.0)
    curves = np.hstack([curves, np.ones((turned.size, 1))])
    # Shares, the rigid one included, add up to one.
    whole = 1e3 * np.ones((1, SPRINGS + 1))
    shares, _ = nnls(np.vstack([curves, whole]), np.append(dahl, 1e3))
    assert np.abs(curves @ shares - dahl)[turned > 0.2 * angle].max() < 0.25
