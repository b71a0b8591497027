"""What is told from readings in a row."""

import math

import numpy as np
import pytest

from bdt_driver.drive import Reading
from bdt_driver.hardware_check.record import Record


def record(positions, voltages=None, **samples):
    voltages = [0.0] * len(positions) if voltages is None else voltages
    times = [0.002 * number for number in range(len(positions))]
    readings = [Reading(p, v, **samples) for p, v in zip(positions, voltages, strict=True)]
    return Record(times, [time + 0.001 for time in times], readings)


def test_noise_is_the_standard_deviation_whatever_the_drift_and_single_spikes():
    positions = np.random.default_rng(1).normal(0.0, 2e-6, 5000)
    assert record(positions).noise() == pytest.approx(2e-6, rel=0.05)
    positions += np.linspace(0.0, 1e-3, 5000)
    positions[::500] += 1.0
    assert record(positions).noise() == pytest.approx(2e-6, rel=0.05)


def test_a_voltage_is_told_at_the_end_of_the_first_reading_that_has_half_of_it():
    told = record([0.0] * 4, [0.0, -1.0, -2.0, -2.0])
    assert told.time_until_told(-2.0) == pytest.approx(0.003)
    assert math.isinf(told.time_until_told(2.0))
    assert told.largest_told() == -2.0


def test_zero_is_less_than_a_hundredth():
    assert record([0.0] * 3, [2.0, 1.0, 0.01]).time_until_zero(2.0) == pytest.approx(0.005)
    assert math.isinf(record([0.0] * 2, [2.0, 1.0]).time_until_zero(2.0))


def test_samples_are_counted_with_those_that_are_lost():
    told = record([0.0] * 3, samples=np.zeros((4, 2)), lost=2)
    assert told.passed_samples.tolist() == [6.0, 12.0, 18.0]
    assert told.lost_samples == 6
    assert record([0.0] * 3).passed_samples.tolist() == [0.0, 0.0, 0.0]


def test_calls_last_and_the_platform_moves():
    told = record([0.001, 0.002, 0.004])
    assert told.call_times == pytest.approx([0.001] * 3)
    assert told.change == pytest.approx(0.003)


def test_records_are_joined_in_their_order():
    joined = record([0.001, 0.002]) + record([0.003])
    assert joined.positions.tolist() == [0.001, 0.002, 0.003]
    assert len(joined.began) == len(joined.ended) == 3
