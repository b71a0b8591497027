"""What a machine's telemetry becomes, against the signals that it was sampled from."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.even_samples import EvenSamples, cubic, held_means, split_at_holes

RATE = 5000.0
JITTER = 4e-5


def position(times):
    """Return a motion of a few millimeters, as that of a platform [m]."""
    return 3e-3 * np.sin(4.0 * times) + 1e-3 * np.sin(17.0 * times)


def voltage(times):
    """Return a voltage that a controller at 500 Hz holds [V]."""
    return 10.0 * np.sin(6.0 * np.floor(times * 500.0 + 1e-6) / 500.0)


def rows_at(times, stamps=None):
    return np.column_stack([times if stamps is None else stamps, voltage(times), position(times)])


def taken(rows, cuts=(), rate=RATE):
    even = EvenSamples(rate)
    parts = [even.take(part) for part in np.split(rows, sorted(set(cuts)))]
    return np.concatenate(parts), even.sampling


def jittered(count, seed=0, spread=JITTER):
    generator = np.random.default_rng(seed)
    return np.arange(count) / RATE + np.clip(generator.normal(0.0, spread, count), -9e-5, 9e-5)


@given(st.lists(st.integers(1, 999), max_size=6), st.floats(-5e-3, 5e-3))
def test_even_telemetry_is_left_as_it_is(cuts, drift):
    """That of a clock that is off by less than a hundredth, too."""
    rows = rows_at(np.arange(1000) / (RATE * (1.0 + drift)))
    found, sampling = taken(rows, cuts)
    assert found.tobytes() == rows.tobytes()
    assert sampling.is_even
    assert str(sampling) == "even"


def test_samples_taken_when_the_stamps_say_are_interpolated_there():
    found, sampling = taken(rows_at(jittered(20_000)), range(500, 20_000, 500))
    assert np.diff(found[:, 0]) == pytest.approx(1.0 / RATE, rel=1e-6)
    assert np.abs(found[:, 2] - position(found[:, 0])).max() < 1e-9
    assert sampling.by_stamps
    assert sampling.jitter == pytest.approx(JITTER, rel=0.2)
    assert "taken when the stamps say" in str(sampling)


def test_samples_taken_evenly_and_stamped_late_are_put_back():
    times = np.arange(20_000) / RATE
    found, sampling = taken(rows_at(times, jittered(20_000)), range(500, 20_000, 500))
    assert not sampling.by_stamps
    assert "taken evenly" in str(sampling)
    settled = found[:, 0] > 1.0
    assert np.abs(found[:, 2] - position(found[:, 0]))[settled].max() < 1e-7


def test_what_comes_in_bunches_is_put_back():
    numbers = np.arange(20_000)
    stamps = (numbers // 5 + 1) * 1e-3 + numbers % 5 * 1e-6
    found, sampling = taken(rows_at(numbers / RATE, stamps), range(500, 20_000, 500))
    assert not sampling.by_stamps
    assert sampling.rate == pytest.approx(RATE, rel=1e-4)
    settled = found[:, 0] > 1.0
    # A constant delay is a twin's unknown.
    delay = np.mean(stamps - numbers / RATE)
    error = found[:, 2] - position(found[:, 0] - delay)
    assert np.abs(error)[settled].max() < 1e-6


def test_the_rate_of_what_is_returned_is_the_nominal_one():
    found, sampling = taken(rows_at(1.004 * jittered(20_000)), range(500, 20_000, 500))
    assert np.diff(found[:, 0]) == pytest.approx(1.0 / RATE, rel=1e-6)
    assert sampling.rate == pytest.approx(RATE / 1.004, rel=1e-4)


@given(st.lists(st.integers(1, 2999), max_size=8))
def test_what_is_sampled_where_the_stamps_say_does_not_depend_on_the_batches(cuts):
    rows = rows_at(jittered(3000))
    expected, _ = taken(rows)
    even = EvenSamples(RATE)
    even.take(rows[:0])
    found, _ = taken(rows, cuts)
    common = min(len(expected), len(found))
    assert common > 2900
    # A first batch of a few samples may happen to be even, and is left where it is.
    assert found[:common, 2] == pytest.approx(position(found[:common, 0]), abs=1e-9)


def test_the_motor_gets_the_same_voltage_as_a_whole():
    rows = rows_at(jittered(5000))
    found, _ = taken(rows, range(500, 5000, 500))
    begin, end = found[0, 0], found[-1, 0] + 1.0 / RATE
    times = np.append(rows[:, 0], rows[-1, 0] + 1.0 / RATE)
    held = np.clip(times[1:], begin, end) - np.clip(times[:-1], begin, end)
    assert found[:, 1].sum() / RATE == pytest.approx(rows[:, 1] @ held, rel=1e-9)


def test_a_lost_sample_is_interpolated_and_a_hole_is_left():
    rows = rows_at(np.delete(np.arange(2000), [700, 1300, 1301]) / RATE)
    found, sampling = taken(rows, range(500, 1900, 500))
    assert not sampling.is_even
    assert np.abs(found[:, 2] - position(found[:, 0])).max() < 1e-9
    hole = rows_at(np.delete(np.arange(2000), slice(1200, 1400)) / RATE)
    parts = split_at_holes(hole, RATE)
    assert [len(part) for part in parts] == [1200, 600]
    even = EvenSamples(RATE)
    for part in parts:
        assert even.take(part).tobytes() == part.tobytes()


@pytest.mark.parametrize(
    "times",
    [
        np.concatenate([np.arange(100), np.arange(300, 400)]) / RATE,
        np.arange(200)[::-1] / RATE,
        np.arange(200) / 4000.0,
        np.full(200, math.nan),
        np.empty(0),
    ],
    ids=["hole", "backward", "another rate", "not a number", "nothing"],
)
def test_what_cannot_be_interpolated_is_left_to_the_estimator(times):
    even = EvenSamples(RATE)
    even.take(rows_at(jittered(500)))
    rows = rows_at(times)
    assert even.take(rows).tobytes() == rows.tobytes()
    follows = even.take(rows_at(10.0 + jittered(500)))
    assert np.abs(follows[:, 2] - position(follows[:, 0])).max() < 1e-9


def test_after_a_restart_even_telemetry_is_left_as_it_is_again():
    even = EvenSamples(RATE)
    even.take(rows_at(jittered(500)))
    even.restart()
    rows = rows_at(np.arange(500) / RATE)
    assert even.take(rows).tobytes() == rows.tobytes()


def test_a_cubic_is_its_own_interpolation():
    times = np.cumsum(np.random.default_rng(1).uniform(0.5, 1.5, 50))
    instants = np.linspace(times[0], times[-1], 200)
    values = ((0.1 * times - 2.0) * times + 1.0) * times - 5.0
    expected = ((0.1 * instants - 2.0) * instants + 1.0) * instants - 5.0
    assert cubic(times, values, instants) == pytest.approx(expected, rel=1e-9)


def test_the_mean_of_a_value_that_holds_is_the_value():
    times, values = np.array([0.0, 1.0, 3.0, 4.0]), np.array([2.0, 4.0, -1.0, 7.0])
    means = held_means(times, values, np.array([0.0, 1.0, 2.0, 4.0]))
    assert means == pytest.approx([2.0, 4.0, 1.5])
