"""The voltage of a motor behind an amplifier that lags, against closed forms and python-control."""

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.applied_voltage import (
    PROMPT,
    applied_voltage,
    compiled_lag,
    lagged,
)
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.stretch import Stretch
from bdt_twin.unknowns import SMALLEST_LAG

T = 1e-3
"""Sample time [s]."""
COMMANDS = np.concatenate([np.zeros(5), np.full(20, 3.0), np.full(30, -2.0), [1.0, 4.0, -1.0]])


def effects_of(**effects):
    return np.array([effects.get(name, 0.0) for name in EFFECTS])


@pytest.mark.parametrize("lag", [2e-4, 1e-3, 5e-3])
def test_its_means_are_those_of_the_differential_equation(lag):
    fine = 200
    times = np.arange(COMMANDS.size * fine + 1) * T / fine
    # Of commands that are held: those of a sample, up to the end of it.
    held = np.append(np.repeat(COMMANDS, fine), COMMANDS[-1])
    amplifier = control.c2d(control.tf2ss([1.0], [lag, 1.0]), T / fine, "zoh")
    voltage = np.ravel(control.forced_response(amplifier, times, held).outputs)
    expected = (0.5 * (voltage[1:] + voltage[:-1])).reshape(-1, fine).mean(axis=1)
    assert lagged(COMMANDS, lag, T)[0] == pytest.approx(expected, abs=1e-4)


def test_one_that_does_not_lag_gives_what_it_is_told():
    means, per_lag = lagged(COMMANDS, 0.0, T)
    assert (means == COMMANDS).all()
    assert per_lag[1:] == pytest.approx(-np.diff(COMMANDS) / T)


@pytest.mark.parametrize("lag", [2e-4, 1e-3, 5e-3])
def test_the_slope_is_that_of_the_means(lag):
    change = 1e-7
    ahead, behind = (lagged(COMMANDS, lag + sign * change, T)[0] for sign in (1, -1))
    expected = (ahead - behind) / (2 * change)
    assert lagged(COMMANDS, lag, T)[1] == pytest.approx(expected, rel=1e-5, abs=1e-3)


def test_the_slope_at_no_lag_is_that_from_above():
    means, per_lag = lagged(COMMANDS, 0.0, T)
    ahead = lagged(COMMANDS, SMALLEST_LAG, T)[0]
    assert per_lag == pytest.approx((ahead - means) / SMALLEST_LAG, rel=1e-5)


@given(st.floats(0.0, 0.02), st.lists(st.floats(-50.0, 50.0), min_size=1, max_size=30))
def test_it_stays_within_its_commands(lag, commands):
    means, _ = lagged(np.array(commands), lag, T)
    assert min(commands) - 1e-9 <= means.min() <= means.max() <= max(commands) + 1e-9


@given(st.floats(SMALLEST_LAG, 0.02))
def test_it_is_late_by_its_time_constant(lag):
    settled = np.concatenate([[0.0], np.full(600, 1.0)])
    means, _ = lagged(settled, lag, T)
    assert T * (settled - means).sum() == pytest.approx(lag, rel=1e-9)


def test_the_compiled_loop_gives_the_floats_of_plain_python():
    loop, results = compiled_lag(), []
    for each in (loop, getattr(loop, "py_func", loop)):
        means, per_lag = np.empty((2, COMMANDS.size))
        each(COMMANDS, 0.4, 0.3, 200.0, 100.0, means, per_lag)
        results.append((means, per_lag))
    assert np.array_equal(*results)


def test_a_stretch_begins_with_what_the_amplifier_has_not_yet_followed():
    whole = Stretch(0.0, COMMANDS, np.zeros(COMMANDS.size))
    late = Stretch(10.0, COMMANDS[10:], np.zeros(COMMANDS.size - 10), COMMANDS[:10])
    effects = effects_of(voltage_lag=2e-3, voltage_offset=0.05)
    all_of_it, rest = (applied_voltage(each, effects, T) for each in (whole, late))
    assert np.array_equal(all_of_it.voltage, lagged(COMMANDS, 2e-3, T)[0] + 0.05)
    assert np.array_equal(rest.before, all_of_it.voltage[:10])
    assert np.array_equal(rest.voltage, all_of_it.voltage[10:])
    assert np.array_equal(rest.per_lag, all_of_it.per_lag[10:])


def test_one_that_does_not_lag_is_not_asked_what_a_lag_would_do():
    stretch = Stretch(0.0, COMMANDS, np.zeros(COMMANDS.size), COMMANDS[:3])
    applied = applied_voltage(stretch, effects_of(delay=1e-3, voltage_offset=0.1), T)
    assert applied.per_lag is PROMPT
    assert np.array_equal(applied.voltage, COMMANDS + 0.1)
    assert np.array_equal(applied.before, COMMANDS[:3] + 0.1)
