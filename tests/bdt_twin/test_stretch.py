"""Means of telemetry turn the motor as far as the telemetry, and are where it does not change."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.stretch import Stretch


def stretch_of(voltage, first=1000, before=0):
    """Return a stretch whose position is the number of its sample."""
    voltage = np.asarray(voltage, dtype=float)
    position = first + np.arange(voltage.size - before, dtype=float)
    return Stretch(first, voltage[before:], position, voltage[:before])


@given(st.integers(1, 12), st.integers(1, 6), st.integers(0, 30), st.data())
def test_a_mean_voltage_is_that_from_one_middle_to_the_next(every, block, before, data):
    """The integral of the voltage, as time passes, is that of the means at each of the middles."""
    size = data.draw(st.integers(2 * every * block, 4 * every * block)) + before
    voltage = np.array(data.draw(st.lists(st.integers(-9, 9), min_size=size, max_size=size)))
    stretch = stretch_of(voltage, before=before)
    means = stretch.averaged(every, block)
    turned = np.concatenate([[0.0], np.cumsum(np.append(voltage, [voltage[-1]] * every))])
    lead = means.before.size
    numbers = np.arange(-lead, means.voltage.size + 1)
    middles = every * (means.first + numbers) - stretch.first + before
    integral = np.interp(middles, np.arange(turned.size), turned)
    found = every * np.append(means.before, means.voltage)
    assert found == pytest.approx(np.diff(integral), abs=1e-9)


@given(st.integers(1, 12), st.integers(1, 6), st.integers(0, 11), st.integers(-5, 5))
def test_a_mean_position_is_that_in_the_middle_of_its_samples(every, block, extra, first):
    means = stretch_of(np.zeros(3 * every * block + extra), first).averaged(every, block)
    numbers = means.first + np.arange(means.position.size)
    assert means.position == pytest.approx(every * numbers)
    assert means.position.size % block == 0
    assert means.readings.reshape(-1, every).mean(axis=1) == pytest.approx(means.position)


@pytest.mark.parametrize("change", range(5))
def test_the_middles_are_where_a_controller_changes_the_voltage(change):
    """A controller's voltage, held for ten samples, is none that nobody commanded."""
    voltage = np.repeat(np.random.default_rng(change).normal(size=30), 10)[9 - change :]
    means = stretch_of(voltage).averaged(5, 5)
    off = np.abs(means.voltage[:, None] - voltage[None, :]).min(axis=1)
    assert off.max() < 1e-12
    assert voltage.size - 5 * means.voltage.size < 5 + 25


def test_means_of_means_are_those_of_the_readings():
    stretch = stretch_of(np.random.default_rng(7).normal(size=480), before=30)
    twice = stretch.averaged(3, 1).averaged(5, 1)
    assert twice.readings.reshape(-1, 15).mean(axis=1) == pytest.approx(twice.position)
    assert 15 * (twice.first + np.arange(twice.position.size)) == pytest.approx(twice.position)


def test_means_of_single_samples_are_the_samples():
    stretch = stretch_of(np.arange(40), before=10)
    same = stretch.averaged(1, 5)
    for one, other in zip(same[1:4], stretch[1:4], strict=True):
        assert (one == other).all()
    assert same.first == stretch.first


@pytest.mark.parametrize(("count", "lead"), [(30, 4), (100, 4), (999, 4), (30, 80)])
def test_the_newest_samples_are_the_last_with_those_before_them(count, lead):
    voltage = np.random.default_rng(3).normal(size=120)
    whole = stretch_of(voltage, before=20).averaged(1, 1)
    newest = whole.newest(count, lead)
    kept = min(count, 100)
    assert newest.first + np.arange(kept) == pytest.approx(newest.position)
    assert np.array_equal(newest.voltage, voltage[120 - kept :])
    assert np.array_equal(newest.before, voltage[: 120 - kept][-lead:])
    assert np.array_equal(newest.readings, newest.position)
