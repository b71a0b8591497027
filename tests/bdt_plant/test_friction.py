"""Coulomb friction against the differential equations, solved with located events."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from bdt_plant.friction import discretize_friction, friction_voltage, frictional_motor_step
from bdt_plant.motor import MotorParameters, MotorState, discretize_motor, motor_step

# Table 1, written again so that a wrong default is seen.
J, L, R, K_T, K_B = 5e-6, 1e-3, 12.0, 0.8, 0.1
TORQUE, VISCOUS = 0.02, 1e-4
HOLD = 2e-3  # time for which the controller holds a voltage
REST = MotorState(0.0, 0.0, 0.0)


def motion_of(state, voltage):
    """Return 1 or -1 for the direction in which the motor turns from now on, 0 if it sticks."""
    current, speed, _ = state
    if speed != 0.0:
        return int(math.copysign(1, speed))
    excess = abs(K_T * current) - TORQUE
    grows = (voltage - R * current) * current > 0
    if excess > 1e-12 or (excess > -1e-12 and grows):
        return int(math.copysign(1, current))
    return 0


def solve_for(state, voltage):
    """Return (i, omega_m, theta_m) after a held voltage; eq. 2 and the law of Coulomb."""
    time, state = 0.0, np.array(state)
    while time < HOLD:
        motion = motion_of(state, voltage)

        def rates(_t, x, motion=motion):
            current, speed, _ = x
            torque = K_T * current - VISCOUS * speed - motion * TORQUE
            return [(voltage - R * current - K_B * speed) / L, abs(motion) * torque / J, speed]

        def stops(_t, x, motion=motion):
            return motion * x[1] + 1e-10  # some room, or the start would be a stop

        def breaks_loose(_t, x):
            return K_T * abs(x[0]) - TORQUE

        event = stops if motion else breaks_loose
        event.terminal, event.direction = True, -1 if motion else 1
        solution = solve_ivp(
            rates, (time, HOLD), state, "DOP853", rtol=1e-10, atol=1e-13, events=event
        )
        time, state = solution.t[-1], solution.y[:, -1].copy()
        if solution.status == 1 and motion:
            state[1] = 0.0
    return state


def solve(voltages):
    state, states = np.array(REST), []
    for voltage in voltages:
        state = solve_for(state, voltage)
        states.append(state)
    return np.array(states)


def run(voltages, samples=10, torque=TORQUE, state=REST):
    """Return the states of the core after each voltage, held for so many samples."""
    motor = MotorParameters(coulomb_friction=torque, viscous_friction=VISCOUS)
    step = discretize_motor(motor, HOLD / samples)
    friction, states = discretize_friction(motor, HOLD / samples), []
    for voltage in voltages:
        for _ in range(samples):
            state = frictional_motor_step(state, float(voltage), step, friction).motor
        states.append(state)
    return np.array(states)


def test_a_standing_motor_turns_above_the_voltage_of_its_friction_and_not_below():
    voltage = friction_voltage(MotorParameters(coulomb_friction=TORQUE))
    assert run([0.999 * voltage] * 20)[-1, 1] == 0.0
    assert run([1.001 * voltage] * 20)[-1, 1] > 0.0


TIMES = np.arange(250) * HOLD
SMOOTH = 3.0 * np.sin(25 * TIMES) * np.cos(4 * TIMES)
ROUGH = np.random.default_rng(4).uniform(-2, 2, TIMES.size)


@pytest.mark.parametrize(
    ("voltages", "angle", "speed"), [(SMOOTH, 1e-4, 5e-3), (ROUGH, 2e-3, 5e-2)]
)
def test_the_motor_moves_and_sticks_as_the_differential_equations_say(voltages, angle, speed):
    """At 5000 Hz, within 0.005 degrees of 60, or 0.1 degrees when the voltage jumps."""
    reference, core = solve(voltages), run(voltages)
    sticks = np.mean(reference[:, 1] == 0.0)
    assert 0.05 < sticks < 0.5  # it does both
    assert np.abs(core[:, 2] - reference[:, 2]).max() < angle
    assert np.abs(core[:, 1] - reference[:, 1]).max() < speed
    assert np.mean((core[:, 1] == 0.0) == (reference[:, 1] == 0.0)) > 0.98


def test_the_error_is_of_second_order_in_the_sample_time():
    reference = solve(SMOOTH)
    errors = [np.abs(run(SMOOTH, samples) - reference)[:, 2].max() for samples in (5, 20, 80)]
    # Factor 16 for each; where in a sample a stop falls is chance.
    assert errors[1] < errors[0] / 4
    assert errors[2] < errors[0] / 100


@settings(max_examples=40)
@given(st.floats(-0.299, 0.299))
def test_a_voltage_too_small_for_the_friction_never_moves_the_motor(voltage):
    current, speed, angle = run([voltage] * 20)[-1]  # friction is R tau / k_T = 0.3 V
    assert speed == angle == 0.0
    assert current == pytest.approx(voltage / R, rel=1e-12)


@settings(max_examples=40)
@given(st.floats(0.301, 24.0), st.sampled_from([1, -1]))
def test_the_steady_speed_is_that_of_the_torque_balance(voltage, sign):
    _, speed, _ = run([sign * voltage] * 30)[-1]
    # k_T i = tau + b w and u = R i + k_B w.
    expected = (voltage - R * TORQUE / K_T) / (K_B + R * VISCOUS / K_T)
    assert speed == pytest.approx(sign * expected, rel=1e-6)


def test_a_coasting_motor_comes_to_exact_rest_and_stays():
    spinning = MotorState(0.0, 100.0, 0.0)
    states = run(np.zeros(200), state=spinning)
    stopped = np.flatnonzero(states[:, 1] == 0.0)
    assert stopped.size
    assert (states[stopped[0] :, 1] == 0.0).all()
    assert len(set(states[stopped[0] :, 2])) == 1
    assert states[-1, 0] == 0.0


@settings(max_examples=40)
@given(st.floats(-24, 24), st.floats(-1, 1), st.floats(-200, 200))
def test_turning_all_signs_turns_the_response_exactly(voltage, current, speed):
    forward = run([voltage], samples=1, state=MotorState(current, speed, 0.0))
    backward = run([-voltage], samples=1, state=MotorState(-current, -speed, 0.0))
    assert (forward == -backward).all()


@settings(max_examples=40)
@given(st.floats(-24, 24), st.floats(-1, 1), st.floats(-200, 200))
def test_friction_never_exceeds_its_level_and_is_all_against_a_motor_that_does_not_turn_back(
    voltage, current, speed
):
    motor = MotorParameters(coulomb_friction=TORQUE)
    step, friction = discretize_motor(motor, 2e-4), discretize_friction(motor, 2e-4)
    moved = frictional_motor_step(MotorState(current, speed, 1.0), voltage, step, friction)
    if moved.motor.speed == speed == 0.0:
        assert max(abs(current), abs(moved.motor.current)) <= TORQUE / K_T
        return
    torque = K_T * (current - moved.driver.current)
    assert abs(torque) <= TORQUE * (1 + 1e-9)
    if speed * moved.motor.speed > 0:
        assert torque == pytest.approx(math.copysign(TORQUE, speed), rel=1e-9)


@settings(max_examples=40)
@given(st.floats(-24, 24), st.floats(-1, 1), st.floats(-200, 200))
def test_the_driver_is_a_motor_without_friction_on_the_same_way(voltage, current, speed):
    motor = MotorParameters(coulomb_friction=TORQUE)
    step, friction = discretize_motor(motor, 2e-4), discretize_friction(motor, 2e-4)
    moved = frictional_motor_step(MotorState(current, speed, 1.0), voltage, step, friction)
    free = motor_step(moved.driver, moved.driver_voltage, step)
    assert free.angle == pytest.approx(moved.motor.angle, abs=1e-12)
    assert free.speed == pytest.approx(moved.motor.speed, abs=1e-9)
