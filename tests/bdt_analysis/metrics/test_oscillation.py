"""Signals with known answers: what is a limit cycle and what is not."""

import numpy as np
import pytest

from bdt_analysis.metrics.oscillation import find_oscillation, turning_points

RATE = 5000.0
TIME = np.arange(round(3.0 * RATE)) / RATE
STRUCTURE = 27.07
"""First mode of the structure [rad/s]; damping 5 %."""


def ringing(start: float = 0.0, rate: float = 0.05 * STRUCTURE) -> np.ndarray:
    since = np.maximum(TIME - start, 0.0)
    return np.exp(-rate * since) * np.cos(STRUCTURE * since) * (start <= TIME)


@pytest.mark.parametrize("period", [0.1, 0.23, 0.5, 0.7, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("phase", np.linspace(0.0, 2 * np.pi, 9))
def test_sine_is_sustained(period: float, phase: float):
    found = find_oscillation(np.sin(2 * np.pi * TIME / period + phase), 1 / RATE)
    assert found.sustained
    assert found.amplitude == pytest.approx(2.0, rel=0.2 if period < 0.2 else 0.03)


@pytest.mark.parametrize("period", [0.5, 1.0, 1.8])
@pytest.mark.parametrize("phase", [0.0, 0.2, 0.5, 0.9])
def test_stick_slip_is_sustained(period: float, phase: float):
    """Stick on one side, slip to the other, ring there: a limit cycle with backlash."""
    cycle = (TIME / period + phase) % 1.0
    since = (cycle % 0.5) * period
    side = np.where(cycle < 0.5, 1.0, -1.0)
    signal = side * (1.0 - 0.6 * np.exp(-1.35 * since) * np.cos(STRUCTURE * since))
    assert find_oscillation(signal, 1 / RATE).sustained


def test_growing_oscillation_is_sustained():
    for rate in (0.1, 0.5, 1.5, 3.0):
        signal = np.exp(rate * TIME) * np.sin(10 * TIME)
        assert find_oscillation(signal, 1 / RATE).sustained, rate


def test_oscillation_on_a_drift_is_sustained():
    found = find_oscillation(0.5 * np.sin(2 * np.pi * TIME) + 2.0 * TIME, 1 / RATE)
    assert found.sustained
    assert found.amplitude < 1.0


@pytest.mark.parametrize("rate", [0.05 * STRUCTURE, 0.8, 0.4])
def test_decaying_ringing_is_not_sustained(rate: float):
    assert not find_oscillation(ringing(rate=rate), 1 / RATE).sustained
    slow = np.exp(-rate * TIME) * np.sin(2 * np.pi * TIME / 0.7)
    assert not find_oscillation(slow, 1 / RATE).sustained


@pytest.mark.parametrize("start", np.arange(0.0, 3.0, 0.1))
def test_one_slip_is_not_sustained(start: float):
    """A slip at any time of the window, with the ringing of the structure after it."""
    slip = (start <= TIME) * 1.0 - ringing(start)
    assert not find_oscillation(slip, 1 / RATE).sustained


@pytest.mark.parametrize("start", [1.3, 1.4, 1.45])
def test_slip_that_rings_on_and_on_is_not_sustained(start: float):
    """Lightly damped ringing reaches the end of the window, but nothing was there before it."""
    slip = (start <= TIME) * 1.0 - ringing(start, rate=0.02 * STRUCTURE)
    assert not find_oscillation(slip, 1 / RATE).sustained


def test_creep_is_not_an_oscillation():
    for signal in (TIME, np.exp(-TIME), np.sqrt(TIME), TIME * 0.0):
        assert find_oscillation(signal, 1 / RATE) == (0.0, False, None)


def test_slip_out_and_back_is_not_sustained():
    signal = ((TIME > 1.0) & (TIME < 2.0)) * 1.0
    assert not find_oscillation(signal, 1 / RATE).sustained


def test_late_slip_after_a_little_noise_is_not_sustained():
    noise = np.random.default_rng(4).normal(0.0, 0.02, TIME.size)
    for start in (2.0, 2.5, 2.8):
        slip = (start <= TIME) * 1.0 - ringing(start)
        assert not find_oscillation(slip + noise, 1 / RATE).sustained, start


def test_noise_is_averaged():
    noise = np.random.default_rng(1).normal(0.0, 1.0, TIME.size)
    assert find_oscillation(noise, 1 / RATE).amplitude < 0.1 * np.ptp(noise)


@pytest.mark.parametrize("rate", [20.0, 100.0, 1000.0])
def test_low_sampling_rates(rate: float):
    time = np.arange(round(3.0 * rate)) / rate
    assert find_oscillation(np.sin(2 * np.pi * time), 1 / rate).sustained
    assert not find_oscillation(np.exp(-1.35 * time) * np.sin(9 * time), 1 / rate).sustained


def test_few_samples():
    assert not find_oscillation(np.array([0.0, 1.0]), 1.0).sustained
    assert not find_oscillation(np.empty(0), 1.0).sustained


def test_turning_points():
    signal = np.array([0.0, 1.0, 0.9, 2.0, 0.0, 0.1, 0.05, 3.0, 2.9])
    assert turning_points(signal, 0.5) == [0, 3, 4, 7]
    assert turning_points(np.zeros(5), 0.5) == []


@pytest.mark.parametrize("frequency", [0.8, 1.43, 3.7, 10.0])
@pytest.mark.parametrize("drift", [0.0, 0.3])
def test_frequency_of_a_sine(frequency: float, drift: float):
    signal = np.sin(2 * np.pi * frequency * TIME + 0.4) + drift * TIME
    assert find_oscillation(signal, 1 / RATE).frequency == pytest.approx(frequency, rel=0.03)


@pytest.mark.parametrize("period", [0.5, 0.7, 1.0])
def test_frequency_of_a_stick_slip_is_that_of_the_cycle_and_not_of_the_ringing(period: float):
    cycle = (TIME / period) % 1.0
    since = (cycle % 0.5) * period
    side = np.where(cycle < 0.5, 1.0, -1.0)
    signal = side * (1.0 - 0.3 * np.exp(-1.35 * since) * np.cos(STRUCTURE * since))
    assert find_oscillation(signal, 1 / RATE).frequency == pytest.approx(1 / period, rel=0.05)


def test_what_does_not_oscillate_has_no_frequency():
    assert find_oscillation(np.zeros_like(TIME), 1 / RATE).frequency is None
    assert find_oscillation(TIME, 1 / RATE).frequency is None
    assert find_oscillation(np.sin(TIME), 1 / RATE).frequency is None
