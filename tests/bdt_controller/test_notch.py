"""The filter in series with the PID, against python-control and what a notch is for."""

import math

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_controller.notch import (
    NO_NOTCH,
    NOTCH_AT_REST,
    NotchFilter,
    discretize_notch,
    notch_at,
    notch_step,
)

PERIOD = 2e-3

notches = st.builds(NotchFilter, st.floats(1.0, 200.0), st.floats(0.0, 2.0), st.floats(0.05, 2.0))
voltages = st.floats(-24.0, 24.0)


def respond(notch, signal, period=PERIOD):
    state, step, answer = NOTCH_AT_REST, discretize_notch(notch, period), []
    for value in signal:
        state, voltage = notch_step(state, float(value), step)
        answer.append(voltage)
    return np.array(answer)


def test_there_is_none_by_default():
    assert NotchFilter() == NO_NOTCH
    assert not discretize_notch(NO_NOTCH, PERIOD).is_on


@pytest.mark.parametrize("notch", [NotchFilter(27.0), NotchFilter(71.0, 0.02, 1.5)])
def test_it_answers_as_the_continuous_filter_does(notch):
    w = notch.frequency
    system = control.tf(
        [1.0, 2 * notch.zero_damping * w, w * w], [1.0, 2 * notch.pole_damping * w, w * w]
    )
    period = 2e-4
    time = np.arange(0.0, 2.0, period)
    signal = np.sin(2.0 * time) + 0.3 * np.sin(30.0 * time)
    expected = control.forced_response(system, time, signal).outputs
    # A held voltage is half a period late on average, and the signal turns by up to 30 rad/s.
    assert np.abs(respond(notch, signal, period) - expected).max() < 30.0 * period


def test_at_its_frequency_little_passes():
    notch = NotchFilter(27.0, 0.05, 0.5)
    time = np.arange(0.0, 8.0, PERIOD)
    answer = respond(notch, np.sin(27.0 * time))[-1000:]
    assert np.abs(answer).max() == pytest.approx(0.1, rel=0.05)


@given(notches, voltages)
def test_a_constant_voltage_passes_in_the_end(notch, voltage):
    slowest = notch.frequency * min(notch.pole_damping, 1.0 / (2.0 * notch.pole_damping))
    answer = respond(notch, np.full(round(30.0 / slowest / PERIOD), voltage))
    assert answer[-1] == pytest.approx(voltage, rel=1e-6, abs=1e-9)


@given(notches, voltages)
def test_from_its_state_for_a_voltage_it_passes_at_once(notch, voltage):
    state, passed = notch_step(notch_at(voltage), voltage, discretize_notch(notch, PERIOD))
    assert passed == pytest.approx(voltage, rel=1e-12, abs=1e-28)
    assert state.low_pass == pytest.approx(voltage, rel=1e-12, abs=1e-28)


@given(notches, st.lists(voltages, min_size=1, max_size=50))
def test_as_much_damping_of_zeros_as_of_poles_is_no_filter(notch, signal):
    even = NotchFilter(notch.frequency, notch.pole_damping, notch.pole_damping)
    assert respond(even, signal).tolist() == signal


@given(notches, st.integers(1, 1000))
def test_it_is_stable_at_any_rate(notch, slowness):
    """The energy that a push leaves behind never grows, at whatever period."""
    step = discretize_notch(notch, 1e-4 * slowness)
    state = notch_at(1.0)
    for _ in range(100):
        energy = state.low_pass**2 + (state.rate / notch.frequency) ** 2
        state, _ = notch_step(state, 0.0, step)
        after = state.low_pass**2 + (state.rate / notch.frequency) ** 2
        assert after <= energy * (1.0 + 1e-12)


def test_what_decays_becomes_zero():
    state, step = notch_at(1e-20), discretize_notch(NotchFilter(27.0), PERIOD)
    for _ in range(5000):
        state, _ = notch_step(state, 0.0, step)
    assert state == NOTCH_AT_REST


@pytest.mark.parametrize(
    ("fault", "text"),
    [
        ({"frequency": -1.0}, "frequency = -1.0 rad/s: must be 0 to 100000 rad/s"),
        ({"zero_damping": math.nan}, "zero_damping = nan: must be 0 to 100"),
        ({"pole_damping": 0.0}, "pole_damping = 0.0: must be 0.01 to 100"),
    ],
)
def test_a_fault_is_named_with_its_value_and_what_is_allowed(fault, text):
    with pytest.raises(ValueError, match=rf"^NotchFilter\.{text}$"):
        NotchFilter(**fault)
