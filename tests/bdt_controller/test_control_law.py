"""What is commanded: the PID, limited without winding up, with its offset, switched smoothly."""

import math
from itertools import pairwise

import control
import numpy as np
import pytest
from dead_zone_pid import dead_zone_pid_step
from hypothesis import given
from hypothesis import strategies as st

from bdt_controller.control_law import (
    BLEND_TIME,
    INITIAL_CONTROL,
    ControlLaw,
    control_step,
    discretize_control,
    switched,
)
from bdt_controller.notch import NO_NOTCH, NotchFilter, discretize_notch
from bdt_controller.pid import INITIAL_PID, PidGains, PidState, discretize_pid, pid_step

PERIOD = 2e-3
NO_FILTER = discretize_notch(NO_NOTCH, PERIOD)
STEP = discretize_pid(PidGains(), PERIOD)
errors = st.floats(-1e-2, 1e-2)
states = st.builds(PidState, st.floats(-1e-2, 1e-2), st.floats(-1e-2, 1e-2))
tolerances = st.sampled_from([0.0, 28e-6, 1e-3])
offsets = st.floats(-1.0, 1.0)


def limited_pid_step(state, error, tolerance, step, limit, offset=0.0):
    """Return state and voltage of a PID without filter in which nothing was reconfigured."""
    law = ControlLaw(step, NO_FILTER, 0.0)
    before = INITIAL_CONTROL._replace(pid=state)
    following, voltage = control_step(before, error, tolerance, law, limit, offset)
    assert following.blend == 0.0
    return following.pid, voltage


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


# Switching ---------------------------------------------------------------------------------

LIMIT = 24.0
gains = st.builds(
    PidGains,
    st.floats(0.0, 1e4),
    st.floats(0.0, 1e5),
    st.floats(-1e3, 1e3),
    st.floats(1e-3, 1.0),
)
notches = st.one_of(
    st.just(NO_NOTCH),
    st.builds(NotchFilter, st.floats(5.0, 200.0), st.floats(0.0, 1.0), st.floats(0.1, 2.0)),
)
laws = st.builds(lambda pid, notch: discretize_control(pid, PERIOD, notch), gains, notches)
pasts = st.lists(errors, min_size=1, max_size=40)


def run(law, past, tolerance, offset=0.0, limit=LIMIT):
    """Return state and voltage of a controller after some errors."""
    state, voltage = INITIAL_CONTROL, 0.0
    for error in past:
        state, voltage = control_step(state, error, tolerance, law, limit, offset)
    return state, voltage


@given(laws, laws, pasts, errors, tolerances, tolerances, offsets, offsets)
def test_a_switch_of_everything_at_once_does_not_move_the_voltage(
    before, after, past, error, narrow, wide, offset, other
):
    """The voltage after the switch is what it would have been without, in any state."""
    state, _ = run(before, past, narrow, offset)
    _, expected = control_step(state, error, narrow, before, LIMIT, offset)
    state = switched(state, error, before, after)
    _, voltage = control_step(state, error, wide, after, LIMIT, other)
    # The blend is a difference of voltages that may be far beyond the limit.
    assert abs(voltage - expected) < 1e-6 * LIMIT


@given(laws, pasts, errors, tolerances, tolerances)
def test_what_a_switch_leaves_behind_dies_away(law, past, error, narrow, wide):
    state, _ = run(law, past, narrow, limit=0.0)
    state, _ = control_step(state, error, wide, law)
    begun = abs(state.blend)
    for _ in range(round(3 * BLEND_TIME / PERIOD)):
        state, _ = control_step(state, error, wide, law)
    assert abs(state.blend) <= 1.01 * math.exp(-3.0) * begun
    for _ in range(round(100 * BLEND_TIME / PERIOD)):
        state, _ = control_step(state, error, wide, law)
    assert state.blend == 0.0


@given(laws, laws, pasts, errors, tolerances)
def test_the_voltage_of_the_integral_is_carried_over(before, after, past, error, tolerance):
    state, _ = run(before, past, tolerance)
    carried = switched(state, error, before, after)
    if after.pid.integral:
        voltage = before.pid.integral * state.pid.integral
        assert after.pid.integral * carried.pid.integral == pytest.approx(
            voltage, rel=1e-12, abs=1e-12
        )
    else:
        assert carried.pid.integral == state.pid.integral
    assert carried.pid.filtered == state.pid.filtered


def test_gains_that_were_switched_without_a_blend_would_jump():
    """What the blend is for: twice the gain, in the middle of a step."""
    before, after = (discretize_control(PidGains(p), PERIOD) for p in (3000.0, 6000.0))
    state, _ = run(before, [1e-3] * 20, 0.0)
    _, expected = control_step(state, 1e-3, 0.0, before, LIMIT)
    _, jumped = control_step(state, 1e-3, 0.0, after, LIMIT)
    assert jumped - expected == pytest.approx(3.0, rel=1e-9)


def test_a_dead_zone_that_closes_over_the_error_lets_the_voltage_fade():
    law = discretize_control(PidGains(), PERIOD)
    state, voltage = run(law, [6e-5] * 200, 5e-5)
    faded = []
    for _ in range(round(4 * BLEND_TIME / PERIOD)):
        state, now = control_step(state, 6e-5, 7e-5, law, LIMIT)
        faded.append(now)
    assert faded[0] == pytest.approx(voltage, rel=0.02)
    assert all(abs(later) < abs(sooner) for sooner, later in pairwise(faded))
    assert abs(faded[-1]) < 0.02 * abs(voltage)


@given(laws, laws, errors)
def test_before_the_first_measurement_there_is_nothing_to_switch(before, after, error):
    assert switched(INITIAL_CONTROL, error, before, after) == INITIAL_CONTROL


@given(pasts, errors)
def test_a_filter_that_comes_in_lets_the_voltage_pass_at_first(past, error):
    plain = discretize_control(PidGains(), PERIOD)
    filtered = discretize_control(PidGains(), PERIOD, NotchFilter(27.0))
    state, _ = run(plain, past, 0.0, limit=0.0)
    carried = switched(state, error, plain, filtered)
    assert carried.notch.low_pass == pytest.approx(pid_step(state.pid, error, plain.pid)[1])
    assert carried.notch.rate == 0.0
