"""The dead zone of eqs 7 and 8 around the PID."""

import math

import numpy as np
import pytest
from dead_zone_pid import dead_zone_pid_step
from hypothesis import given
from hypothesis import strategies as st

from bdt_controller.dead_zone import dead_zone_error
from bdt_controller.pid import INITIAL_PID, PidGains, PidState, discretize_pid, pid_step

STEP = discretize_pid(PidGains(), 2e-3)
TOLERANCE = 28e-6
SOME_STATE = PidState(1e-4, 2e-3)

errors = st.lists(st.floats(-1e-4, 1e-4), min_size=1, max_size=60)
tolerances = st.floats(1e-9, 1e-4)


def run(error, tolerance):
    state, voltages, states = INITIAL_PID, [], []
    for value in error:
        state, voltage = dead_zone_pid_step(state, value, tolerance, STEP)
        voltages.append(voltage)
        states.append(state)
    return voltages, states


def run_linear(error):
    state, voltages, states = INITIAL_PID, [], []
    for value in error:
        state, voltage = pid_step(state, value, STEP)
        voltages.append(voltage)
        states.append(state)
    return voltages, states


@given(errors, tolerances)
def test_outside_the_voltage_is_that_of_the_pid_on_the_clipped_error_and_inside_zero(
    error, tolerance
):
    """Eqs 7 and 8 word for word."""
    inside = [abs(value) <= tolerance for value in error]
    clipped = [0.0 if now else value for now, value in zip(inside, error, strict=True)]
    linear, linear_states = run_linear(clipped)
    voltages, states = run(error, tolerance)
    expected = [0.0 if now else value for now, value in zip(inside, linear, strict=True)]
    assert voltages == expected
    assert states == linear_states


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_edge_of_the_dead_zone_belongs_to_it(sign):
    assert dead_zone_error(sign * TOLERANCE, TOLERANCE) == 0.0
    state, voltage = dead_zone_pid_step(SOME_STATE, sign * TOLERANCE, TOLERANCE, STEP)
    assert voltage == 0.0
    assert state.integral == SOME_STATE.integral


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_next_number_beyond_the_edge_does_not_belong_to_it(sign):
    beyond = sign * math.nextafter(TOLERANCE, 1.0)
    assert dead_zone_error(beyond, TOLERANCE) == beyond
    state, voltage = dead_zone_pid_step(SOME_STATE, beyond, TOLERANCE, STEP)
    assert (state, voltage) == pid_step(SOME_STATE, beyond, STEP)
    assert voltage != 0.0
    assert state.integral != SOME_STATE.integral


@given(st.lists(st.floats(-TOLERANCE, TOLERANCE), min_size=1, max_size=60))
def test_the_integral_does_not_move_in_the_dead_zone(error):
    state = SOME_STATE
    for value in error:
        state, voltage = dead_zone_pid_step(state, value, TOLERANCE, STEP)
        assert state.integral == SOME_STATE.integral
        assert voltage == 0.0


def test_the_filter_of_the_derivative_decays_in_the_dead_zone():
    state, _ = dead_zone_pid_step(SOME_STATE, TOLERANCE / 2, TOLERANCE, STEP)
    expected = SOME_STATE.filtered * math.exp(-2e-3 / PidGains().filter_time)
    assert state.filtered == pytest.approx(expected, rel=1e-15)


@given(errors)
def test_a_tolerance_of_zero_is_the_linear_controller(error):
    error = [*error, 0.0, *error]
    assert run(error, 0.0) == run_linear(error)


def test_a_tolerance_of_zero_is_linear_also_where_the_error_is_exactly_zero():
    _, voltage = dead_zone_pid_step(SOME_STATE, 0.0, 0.0, STEP)
    assert voltage == pid_step(SOME_STATE, 0.0, STEP)[1]
    assert voltage != 0.0


@given(errors, tolerances)
def test_turning_all_signs_turns_the_voltage_exactly(error, tolerance):
    forward, backward = run(error, tolerance)[0], run([-value for value in error], tolerance)[0]
    assert (np.array(forward) == -np.array(backward)).all()
