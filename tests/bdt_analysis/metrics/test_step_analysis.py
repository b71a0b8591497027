"""Steps with closed-form answers."""

import math

import numpy as np
import pytest

from bdt_analysis.metrics.oscillation import find_oscillation
from bdt_analysis.metrics.reference_steps import find_steps
from bdt_analysis.metrics.step_analysis import (
    LOOKED_AT_ONCE,
    has_limit_cycle,
    settling_time,
    summarize_step,
)

RATE = 1000.0
HEIGHT = 5e-3


def summaries(position, reference=((0.0, HEIGHT),), duration: float = 10.0):
    time = np.arange(round(duration * RATE)) / RATE
    rows = np.stack([time, 0 * time, position(time)], axis=1)
    steps = find_steps(np.array(reference), rows, 1 / RATE)
    return [summarize_step(step, rows, 1 / RATE) for step in steps]


def first_order(time):
    return HEIGHT * (1 - np.exp(-2 * time))


def test_settling_of_a_first_order_lag():
    (step,) = summaries(first_order)
    assert step.settling_time_s == pytest.approx(math.log(50) / 2, abs=2e-3)
    assert step.bias_m == pytest.approx(0.0, abs=1e-8)
    assert step.limit_cycle is False


def test_bias_has_a_sign_and_is_relative_to_the_height():
    def short_of_it(time):
        return 0.98 * first_order(time)

    (step,) = summaries(short_of_it)
    assert step.bias_m == pytest.approx(-1e-4, rel=1e-3)
    assert step.bias_percent_of_amplitude == pytest.approx(-2.0, rel=1e-3)


def test_step_down_has_the_bias_of_its_own_height():
    def two_steps(time):
        return np.where(time < 10, 3e-3, 1e-3) + 1e-5

    _, second = summaries(two_steps, [(0.0, 3e-3), (10.0, 1e-3)], 20.0)
    assert second.bias_percent_of_amplitude == pytest.approx(0.5)


@pytest.mark.parametrize(("size", "expected"), [(0.9e-2, False), (1.1e-2, True), (8e-2, True)])
def test_constant_sine(size: float, expected: bool):
    def oscillating(time):
        return first_order(time) + 0.5 * size * HEIGHT * np.sin(2 * np.pi * time / 0.7)

    (step,) = summaries(oscillating)
    assert step.residual_peak_to_peak_m == pytest.approx(size * HEIGHT, rel=1e-3)
    assert step.limit_cycle is expected
    assert (step.settling_time_s is None) is (size > 4e-2)


def test_ringing_in_the_dead_zone_settles():
    """Ringing of 27 rad/s, damping 5 %: the envelope passes 2 % at ln(1 / 0.02) / 1.35 s."""

    def ringing(time):
        return HEIGHT * (1 - np.exp(-1.35 * time) * np.cos(27.0 * time))

    (step,) = summaries(ringing)
    envelope = math.log(1 / 0.02) / 1.35
    assert envelope - 0.24 < step.settling_time_s <= envelope
    assert step.limit_cycle is False


def test_large_late_ringing_is_not_a_limit_cycle():
    def ringing(time):
        since = np.maximum(time - 6.9, 0)
        return first_order(time) + 0.2 * HEIGHT * np.exp(-1.35 * since) * np.sin(27.0 * since)

    (step,) = summaries(ringing)
    assert step.residual_peak_to_peak_m > 0.2 * HEIGHT
    assert step.limit_cycle is False


def test_creep_is_not_a_limit_cycle():
    def creep(time):
        return HEIGHT * (0.8 + 0.02 * time)

    (step,) = summaries(creep)
    assert step.limit_cycle is False
    assert step.settling_time_s is None


def test_noise_is_not_a_limit_cycle():
    noise = np.random.default_rng(2).normal(0.0, 1.2e-5, 3000)
    assert np.ptp(noise) > 0.01 * HEIGHT
    assert has_limit_cycle(find_oscillation(noise, 1 / RATE), np.ptp(noise), HEIGHT) is False


def test_last_step_that_is_cut_says_nothing():
    _, last = summaries(first_order, [(0.0, HEIGHT), (10.0, 0.0)], 11.0)
    assert last.t_start_s == 10.0
    assert last.reference_m == 0.0
    assert last.residual_peak_to_peak_m is None
    assert last.bias_m is None
    assert last.bias_percent_of_amplitude is None
    assert last.settling_time_s is None
    assert last.limit_cycle is None


def test_very_short_steps_have_a_bias_only():
    reference = [(0.1 * k, 1e-3 * (k % 2)) for k in range(20)]
    for step in summaries(first_order, reference, 2.0)[1:]:
        assert step.bias_m is not None
        assert step.settling_time_s is None
        assert step.limit_cycle is None


def test_oscillation_around_the_first_position():
    """Without any step, the reference itself is what an oscillation is compared with."""

    def oscillating(time):
        return HEIGHT * (1 + 0.02 * np.sin(2 * np.pi * time))

    (step,) = summaries(oscillating)
    assert step.limit_cycle is True
    assert step.bias_percent_of_amplitude is None


def test_limit_cycle_needs_a_height():
    sine = np.sin(np.arange(3000) / 100)
    assert has_limit_cycle(find_oscillation(sine, 1 / RATE), 2.0, None) is None


def test_settling_time():
    time = np.arange(10.0)
    assert settling_time(time, 0.0, np.zeros(10), 0.0, 0.1, 8.0) == 0.0
    assert settling_time(time, 0.0, (time < 4) * 1.0, 0.0, 0.1, 8.0) == 4.0
    assert settling_time(time, 0.0, (time > 8) * 1.0, 0.0, 0.1, 8.0) is None
    assert settling_time(time, 0.0, (time > 8) * 1.0, 0.0, 0.1, 10.0) is None
    assert settling_time(time + 5.0, 5.0, (time < 4) * 1.0, 0.0, 0.1, 8.0) == 4.0


@pytest.mark.parametrize("last", [0, 1, LOOKED_AT_ONCE - 1, LOOKED_AT_ONCE, 3 * LOOKED_AT_ONCE])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_settling_time_of_a_long_step(last, side):
    time = np.arange(3.5 * LOOKED_AT_ONCE)
    position = np.full(time.size, 2.0)
    position[last] += 0.2 * side
    assert settling_time(time, 0.0, position, 2.0, 0.1, time[-1]) == last + 1.0


def test_a_missing_sample_hides_no_other_one_outside_the_band():
    time, position = np.arange(10.0), np.zeros(10)
    position[3], position[6] = 1.0, np.nan
    assert settling_time(time, 0.0, position, 0.0, 0.1, 8.0) == 4.0
