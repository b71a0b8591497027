"""The limited PID: off it is the PID of the paper, on it does not wind up; its offset."""

import math

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_controller.dead_zone import dead_zone_pid_step
from bdt_controller.pid import INITIAL_PID, PidGains, PidState, discretize_pid
from bdt_controller.voltage_limit import limited_pid_step

PERIOD = 2e-3
STEP = discretize_pid(PidGains(), PERIOD)
errors = st.floats(-1e-2, 1e-2)
states = st.builds(PidState, st.floats(-1e-2, 1e-2), st.floats(-1e-2, 1e-2))
tolerances = st.sampled_from([0.0, 28e-6, 1e-3])
offsets = st.floats(-1.0, 1.0)


@given(states, errors, tolerances)
def test_without_a_limit_it_is_the_dead_zone_pid_bit_for_bit(state, error, tolerance):
    expected = dead_zone_pid_step(state, error, tolerance, STEP)
    assert limited_pid_step(state, error, tolerance, STEP, 0.0) == expected
    assert limited_pid_step(state, error, tolerance, STEP, 1e6) == expected
    assert limited_pid_step(state, error, tolerance, STEP, 1e6, 0.0) == expected


def test_an_offset_of_zero_keeps_the_sign_of_a_zero():
    reverse = discretize_pid(PidGains(-1.0, -1.0, -1.0), PERIOD)
    _, voltage = limited_pid_step(INITIAL_PID, 0.0, 0.0, reverse, 0.0, 0.0)
    assert math.copysign(1.0, voltage) == -1.0


@given(states, errors, tolerances, offsets)
def test_an_offset_is_added_to_every_voltage_and_the_state_knows_nothing_of_it(
    state, error, tolerance, offset
):
    free, wanted = dead_zone_pid_step(state, error, tolerance, STEP)
    assert limited_pid_step(state, error, tolerance, STEP, 0.0, offset) == (free, wanted + offset)


@pytest.mark.parametrize("offset", [0.02, -0.02])
def test_in_the_dead_zone_the_offset_is_all(offset):
    state = PidState(1e-3, 1e-4)
    after, voltage = limited_pid_step(state, 1e-5, 2e-5, STEP, 24.0, offset)
    assert (after.integral, voltage) == (state.integral, offset)


@given(states, errors, tolerances, st.floats(0.1, 48.0), offsets)
def test_the_sum_is_what_is_limited(state, error, tolerance, limit, offset):
    free, wanted = dead_zone_pid_step(state, error, tolerance, STEP)
    after, voltage = limited_pid_step(state, error, tolerance, STEP, limit, offset)
    assert voltage == max(-limit, min(limit, wanted + offset))
    if abs(wanted + offset) <= limit:
        assert after == free


def test_the_integral_stops_at_the_limit_of_the_sum():
    near = PidState(23.5 / PidGains().integral, 0.0)
    error = 1e-8
    free, _ = limited_pid_step(near, error, 0.0, STEP, 24.0)
    assert free.integral > near.integral
    held, voltage = limited_pid_step(near, error, 0.0, STEP, 24.0, 1.0)
    assert (held.integral, voltage) == (near.integral, 24.0)
    back, _ = limited_pid_step(near, -error, 0.0, STEP, 24.0, 1.0)
    assert back.integral < near.integral


@given(states, errors, tolerances, st.floats(0.1, 48.0))
def test_the_voltage_is_the_nearest_one_within_the_limit(state, error, tolerance, limit):
    free, wanted = dead_zone_pid_step(state, error, tolerance, STEP)
    after, voltage = limited_pid_step(state, error, tolerance, STEP, limit)
    assert voltage == max(-limit, min(limit, wanted))
    assert after.filtered == free.filtered
    assert after.integral in (state.integral, free.integral)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_at_the_limit_the_integral_can_only_come_back(sign):
    wound = PidState(sign * 1e-3, 0.0)  # 31 V of integral
    deeper, voltage = limited_pid_step(wound, sign * 1e-3, 0.0, STEP, 24.0)
    assert voltage == math.copysign(24.0, sign)
    assert deeper.integral == wound.integral
    back, voltage = limited_pid_step(wound, -sign * 1e-4, 0.0, STEP, 24.0)
    assert voltage == math.copysign(24.0, sign)
    assert abs(back.integral) < abs(wound.integral)


@pytest.mark.parametrize("gain", [1.0, -1.0])
def test_it_does_so_for_an_integral_gain_of_either_sign(gain):
    step = discretize_pid(PidGains(0.0, gain * 1e4, 0.0, 0.1), PERIOD)
    state = INITIAL_PID
    for _ in range(5000):
        state, voltage = limited_pid_step(state, 1e-2, 0.0, step, 24.0)
    assert voltage == math.copysign(24.0, gain)
    assert abs(1e4 * state.integral) <= 24.0 + 1e4 * PERIOD * 1e-2


def overshoot(limit):
    """Return overshoot and last error of 1 / (s (0.1 s + 1)) behind an amplifier of 2 V."""
    plant = control.sample_system(control.tf([1.0], [0.1, 1.0, 0.0]), PERIOD, "zoh")
    plant = control.ss(plant)
    gains = discretize_pid(PidGains(2.0, 2.0, 0.0, 0.1), PERIOD)
    state, x, position = INITIAL_PID, np.zeros((2, 1)), []
    for _ in range(10_000):
        position.append((plant.C @ x).item())
        state, voltage = limited_pid_step(state, 10.0 - position[-1], 0.0, gains, limit)
        x = plant.A @ x + plant.B * max(-2.0, min(2.0, voltage))
    return max(position) - 10.0, abs(position[-1] - 10.0)


def test_a_large_step_overshoots_less_than_with_a_pid_that_winds_up():
    (limited, rest), (wound_up, _) = overshoot(2.0), overshoot(0.0)
    assert limited < 0.4 * wound_up
    assert rest < 0.1
