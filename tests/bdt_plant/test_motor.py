"""The motor against eq. 2 of the paper, integrated and transformed by other means."""

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from bdt_plant.motor import (
    SMALLEST_SIGNAL,
    MotorParameters,
    MotorState,
    discretize_motor,
    motor_step,
)

# Table 1, written again so that a wrong default is seen.
J, L, R, K_T, K_B = 5e-6, 1e-3, 12.0, 0.8, 0.1
EQ_2 = control.tf([K_T], [J * L, J * R, K_B * K_T, 0])
SAMPLE_TIME = 2e-4
AT_REST = MotorState(0.0, 0.0, 0.0)

voltages = st.floats(-100, 100)
sample_times = st.floats(1e-5, 1e-2)


def run(held_voltages, sample_time=SAMPLE_TIME, state=AT_REST):
    """Return (current, speed, angle) after each held voltage, shape (n, 3)."""
    step = discretize_motor(MotorParameters(), sample_time)
    states = []
    for voltage in held_voltages:
        state = motor_step(state, float(voltage), step)
        states.append(state)
    return np.array(states)


def integrate(held_voltages):
    """Return the same by an ODE solver on the differential equations behind eq. 2."""
    states, state = [], np.array(AT_REST)
    for voltage in held_voltages:

        def rates(_time, x, u=voltage):
            current, speed, _angle = x
            return [(u - R * current - K_B * speed) / L, K_T * current / J, speed]

        state = solve_ivp(rates, (0, SAMPLE_TIME), state, "DOP853", rtol=1e-10, atol=1e-13).y[:, -1]
        states.append(state)
    return np.array(states)


def random_voltages(count):
    return np.random.default_rng(1).uniform(-24, 24, count)


held_voltage_cases = pytest.mark.parametrize(
    "held_voltages", [np.full(200, 12.0), random_voltages(200)], ids=["step", "random"]
)


@held_voltage_cases
def test_the_state_is_that_of_the_integrated_differential_equations(held_voltages):
    expected = integrate(held_voltages)
    largest = np.abs(expected).max(axis=0)
    # The solver is right to 1e-10 a sample, and the motor forgets its errors within five.
    error = np.abs(run(held_voltages) - expected).max(axis=0)
    assert (error <= 1e-9 * largest).all()


@held_voltage_cases
def test_the_angle_is_that_of_eq_2_behind_a_zero_order_hold(held_voltages):
    held = control.sample_system(control.ss(EQ_2), SAMPLE_TIME, "zoh")
    times = np.arange(held_voltages.size + 1) * SAMPLE_TIME
    expected = control.forced_response(held, times, np.append(held_voltages, 0.0)).outputs
    # Angles of some radians; what remains is rounding.
    np.testing.assert_allclose(run(held_voltages)[:, 2], expected[1:], rtol=0, atol=1e-11)


def test_the_angle_follows_the_continuous_step_response_of_eq_2():
    times = np.arange(201) * SAMPLE_TIME
    expected = 12.0 * control.step_response(EQ_2, times).outputs
    np.testing.assert_allclose(run(np.full(200, 12.0))[:, 2], expected[1:], rtol=0, atol=1e-11)


def test_the_steady_speed_is_the_voltage_over_the_back_emf_constant():
    current, speed, _ = run(np.full(1000, 12.0))[-1]
    assert speed == pytest.approx(12.0 / K_B, rel=1e-12)
    assert current == pytest.approx(0.0, abs=1e-12)  # nothing brakes the motor but the back-EMF


def test_viscous_friction_is_one_more_term_of_the_same_linear_model():
    friction = 3e-4
    with_friction = control.tf([K_T], [J * L, J * R + friction * L, K_B * K_T + friction * R, 0])
    held = control.sample_system(control.ss(with_friction), SAMPLE_TIME, "zoh")
    voltages = random_voltages(200)
    times = np.arange(voltages.size + 1) * SAMPLE_TIME
    expected = control.forced_response(held, times, np.append(voltages, 0.0)).outputs
    step = discretize_motor(MotorParameters(viscous_friction=friction), SAMPLE_TIME)
    state, angles = AT_REST, []
    for voltage in voltages:
        state = motor_step(state, float(voltage), step)
        angles.append(state.angle)
    np.testing.assert_allclose(angles, expected[1:], rtol=0, atol=1e-11)


def test_the_poles_are_those_of_eq_2():
    step = discretize_motor(MotorParameters(), SAMPLE_TIME)
    one_sample = [(*step.current[:2], 0), (*step.speed[:2], 0), (*step.angle[:2], 1)]
    expected = np.exp(np.roots([J * L, J * R, K_B * K_T, 0]) * SAMPLE_TIME)
    np.testing.assert_allclose(
        np.sort(np.linalg.eigvals(one_sample)), np.sort(expected), rtol=0, atol=1e-12
    )


@given(voltages, sample_times, voltages, voltages)
def test_two_short_samples_are_one_long_sample(voltage, sample_time, current, speed):
    start = MotorState(current, speed, 1.0)
    two = run([voltage, voltage], sample_time / 2, start)[-1]
    one = run([voltage], sample_time, start)[-1]
    # Rounding of the matrix exponentials, relative to currents of up to 100 A times k_T / J.
    np.testing.assert_allclose(two, one, rtol=1e-9, atol=1e-9)


@given(voltages, voltages, voltages, voltages)
def test_turning_all_signs_turns_the_response_exactly(voltage, current, speed, angle):
    forward = run([voltage], state=MotorState(current, speed, angle))
    backward = run([-voltage], state=MotorState(-current, -speed, -angle))
    assert (forward == -backward).all()


def test_a_motor_without_voltage_comes_to_exact_rest():
    current, speed, angle = run(np.zeros(5000), state=MotorState(0.5, 100.0, 3.0)).T
    assert current[-1] == 0.0
    assert speed[-1] == 0.0
    assert angle[-1] == angle[-100]  # and then stays


def test_no_decaying_signal_becomes_subnormal():
    current, speed, _ = run(np.zeros(5000), state=MotorState(0.5, 100.0, 3.0)).T
    for signal in (current, speed):
        moving = np.abs(signal[signal != 0.0])
        assert moving.min() >= SMALLEST_SIGNAL


def test_a_small_signal_above_the_limit_is_kept():
    current, speed, _ = run([0.0], state=MotorState(0.0, 1e-25, 0.0))[-1]
    assert current != 0.0
    assert speed != 0.0


@pytest.mark.parametrize(
    "name", ["inertia", "inductance", "resistance", "torque_constant", "back_emf_constant"]
)
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), float("inf"), "12", None, True])
def test_a_constant_that_no_motor_has_is_refused(name, value):
    with pytest.raises(ValueError, match=rf"MotorParameters\.{name} = .*must be .* to "):
        MotorParameters(**{name: value})


@pytest.mark.parametrize("name", ["viscous_friction", "coulomb_friction"])
@pytest.mark.parametrize("value", [-1e-9, float("nan"), float("inf"), "0", None])
def test_a_friction_that_drives_is_refused(name, value):
    with pytest.raises(ValueError, match=rf"MotorParameters\.{name} = .*must be .* to "):
        MotorParameters(**{name: value})


def test_the_defaults_are_table_1():
    assert MotorParameters() == MotorParameters(
        J, L, R, torque_constant=K_T, back_emf_constant=K_B, viscous_friction=0, coulomb_friction=0
    )
