"""The motor against a set-valued resistance: balances in closed form, and solved with events."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from bdt_plant.motor import MotorParameters, MotorState, discretize_motor, motor_step
from bdt_plant.resisted_motor import discretize_resisted_motor, resisted_motor_step

# Table 1, written again so that a wrong default is seen.
J, L, R, K_T, K_B = 5e-6, 1e-3, 12.0, 0.8, 0.1
FORWARD, BACKWARD, LOAD = 0.03, 0.01, 0.004  # torques [N m]
HOLD = 2e-3  # time for which the controller holds a voltage
REST = MotorState(0.0, 0.0, 0.0)
TIMES = np.arange(100) * HOLD
SMOOTH = 3.0 * np.sin(25 * TIMES) * np.cos(4 * TIMES)
ROUGH = np.random.default_rng(4).uniform(-2, 2, TIMES.size)


def advance(state, voltage, steps=100, *, load=LOAD, backward=BACKWARD, forward=FORWARD):
    """Return the state after a held voltage; torques in N m."""
    step = discretize_resisted_motor(MotorParameters(), HOLD / steps)
    currents = (load / K_T, backward / K_T, forward / K_T)
    for _ in range(steps):
        state = resisted_motor_step(state, float(voltage), *currents, step)
    return state


def run(voltages, steps=100, state=REST):
    states = []
    for voltage in voltages:
        state = advance(state, voltage, steps)
        states.append(state)
    return np.array(states)


def direction_of(state, voltage):
    """Return 1 or -1 for the direction in which the motor turns from now on, 0 if it rests."""
    current, speed, _ = state
    if speed != 0.0:
        return int(math.copysign(1, speed))
    torque, growth = K_T * current - LOAD, voltage - R * current
    if torque > FORWARD - 1e-12 and (torque > FORWARD + 1e-12 or growth > 0):
        return 1
    if torque < -BACKWARD + 1e-12 and (torque < -BACKWARD - 1e-12 or growth < 0):
        return -1
    return 0


def solve(voltages):
    """Return the states (i, omega_m, theta_m) after each voltage, with located events."""
    state, states = np.array(REST), []
    for voltage in voltages:
        time = 0.0
        while time < HOLD:
            direction = direction_of(state, voltage)
            resistance = {1: FORWARD, -1: -BACKWARD, 0: 0.0}[direction]

            def rates(_t, x, voltage=voltage, resistance=resistance, direction=direction):
                current, speed, _ = x
                torque = abs(direction) * (K_T * current - LOAD - resistance)
                return [(voltage - R * current - K_B * speed) / L, torque / J, speed]

            def stops(_t, x, direction=direction):
                return direction * x[1] + 1e-10  # some room, or the start would be a stop

            def goes_forward(_t, x):
                return K_T * x[0] - LOAD - FORWARD

            def goes_backward(_t, x):
                return -(K_T * x[0] - LOAD) - BACKWARD

            events = [stops] if direction else [goes_forward, goes_backward]
            for event in events:
                event.terminal, event.direction = True, -1 if direction else 1
            solution = solve_ivp(
                rates, (time, HOLD), state, "DOP853", rtol=1e-10, atol=1e-13, events=events
            )
            time, state = solution.t[-1], solution.y[:, -1].copy()
            if solution.status == 1 and direction:
                state[1] = 0.0
        states.append(state)
    return np.array(states)


@pytest.mark.parametrize(
    ("voltages", "angle", "speed"), [(SMOOTH, 1e-5, 5e-4), (ROUGH, 3e-5, 5e-4)]
)
def test_the_motor_moves_and_rests_as_the_differential_equations_say(voltages, angle, speed):
    reference, core = solve(voltages), run(voltages)
    assert np.mean(reference[:, 1] == 0.0) > 0.05  # it does both
    assert np.abs(core[:, 2] - reference[:, 2]).max() < angle
    assert np.abs(core[:, 1] - reference[:, 1]).max() < speed


def test_the_error_is_of_second_order_in_the_step():
    reference = solve(SMOOTH)
    errors = [np.abs(run(SMOOTH, steps) - reference)[:, 2].max() for steps in (10, 40, 160)]
    # Factor 16 for each; where in a step a stop falls is chance.
    assert errors[1] < errors[0] / 4
    assert errors[2] < errors[0] / 100


@settings(max_examples=40)
@given(st.floats(-0.089, 0.509))
def test_a_voltage_between_the_resistances_never_moves_the_motor(voltage):
    # Held from (-10 + 4) mN m to (30 + 4) mN m, that is -0.09 V to 0.51 V.
    state = REST
    for _ in range(10):
        state = advance(state, voltage)
    assert state.speed == state.angle == 0.0
    assert state.current == pytest.approx(voltage / R, rel=1e-9)


@settings(max_examples=40)
@given(st.floats(0.6, 24.0) | st.floats(-24.0, -0.2))
def test_the_steady_speed_is_that_of_the_torque_balance_of_its_direction(voltage):
    state = REST
    for _ in range(15):
        state = advance(state, voltage, 20)
    torque = LOAD + (FORWARD if voltage > 0 else -BACKWARD)
    assert state.speed == pytest.approx((voltage - R * torque / K_T) / K_B, rel=1e-6)


def test_a_resistance_below_zero_drives_the_motor_as_a_load_drives_a_screw():
    """Held by nothing, the motor turns backward as fast as its back-EMF lets it."""
    state = REST
    for _ in range(15):
        state = advance(state, 0.0, load=0.0, backward=-0.02, forward=0.05)
    assert state.speed == pytest.approx(-R * 0.02 / K_T / K_B, rel=1e-6)


@settings(max_examples=40)
@given(st.floats(-24, 24), st.floats(-1, 1), st.floats(-200, 200))
def test_turning_all_signs_turns_the_response_exactly(voltage, current, speed):
    ahead = advance(MotorState(current, speed, 0.0), voltage, 3)
    mirrored = advance(
        MotorState(-current, -speed, 0.0),
        -voltage,
        3,
        load=-LOAD,
        backward=FORWARD,
        forward=BACKWARD,
    )
    assert tuple(ahead) == tuple(-x for x in mirrored)


@settings(max_examples=40)
@given(st.floats(-24, 24), st.floats(-1, 1), st.floats(-200, 200))
@example(voltage=1.0, current=-1.0, speed=0.0)
def test_without_any_resistance_it_is_the_motor_of_eq_2(voltage, current, speed):
    state = MotorState(current, speed, 1.0)
    moved = advance(state, voltage, 1, load=0.0, backward=0.0, forward=0.0)
    expected = motor_step(state, voltage, discretize_motor(MotorParameters(), HOLD))
    assert moved == pytest.approx(expected, rel=1e-12, abs=1e-15)
