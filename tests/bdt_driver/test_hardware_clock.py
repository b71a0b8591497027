"""Samples of another clock get even times on this one, at the rate that they really have."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_driver.hardware_clock import HardwareClock

RATE = 5000.0


def arrivals(drift, jitter, seconds, seed=0):
    """Return numbers of samples and when they arrive, read 500 times a second."""
    generator = np.random.default_rng(seed)
    counted = 0
    for number in range(round(500 * seconds)):
        now = (number + 1) / 500
        ready = int(now * RATE / (1.0 + drift))
        if ready > counted:
            yield ready - counted, now + jitter * generator.random()
            counted = ready


@given(st.floats(-3e-3, 3e-3), st.floats(0.0, 2e-3), st.integers(0, 99))
def test_the_times_are_even_to_a_hundredth_from_the_first_to_the_last(drift, jitter, seed):
    clock = HardwareClock(RATE)
    times = np.concatenate(
        [clock.times(count, 0, now) for count, now in arrivals(drift, jitter, 4.0, seed)]
    )
    assert np.abs(np.diff(times) * RATE - 1.0).max() < 0.01


@pytest.mark.parametrize("drift", [-2e-3, 0.0, 1e-3])
def test_they_follow_the_rate_that_the_hardware_has(drift):
    clock = HardwareClock(RATE)
    last = [(clock.times(count, 0, now)[-1], now) for count, now in arrivals(drift, 1e-3, 30.0)]
    assert clock.drift == pytest.approx(drift, abs=1e-4)
    behind = np.array([now - time for time, now in last[-500:]])
    assert abs(behind.mean()) < 1e-3
    assert clock.restarts == 0


def test_lost_samples_take_their_time():
    clock = HardwareClock(RATE)
    before = clock.times(10, 0, 1.0)
    after = clock.times(10, 30, 1.008)
    assert after[0] - before[-1] == pytest.approx(31 / RATE)


def test_after_a_long_pause_they_begin_anew():
    clock = HardwareClock(RATE)
    clock.times(10, 0, 1.0)
    assert clock.times(10, 0, 3.0)[-1] == 3.0
    assert clock.restarts == 1
