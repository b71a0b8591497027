"""Decimation keeps the extremes and the gaps."""

import numpy as np
import pytest

from bdt_analysis.figures.decimation import envelope


def test_every_column_keeps_its_extremes():
    rng = np.random.default_rng(3)
    time, value = np.arange(100_000) * 1e-3, rng.normal(size=100_000)
    few_times, few_values = envelope(time, value, 100)
    assert few_times.size <= 400
    assert (np.diff(few_times) > 0).all()
    for column in range(100):
        inside = (time >= column) & (time < column + 1)
        kept = (few_times >= column) & (few_times < column + 1)
        assert few_values[kept].max() == value[inside].max()
        assert few_values[kept].min() == value[inside].min()
    assert few_times[[0, -1]].tolist() == time[[0, -1]].tolist()


def test_short_signals_stay_as_they_are():
    time, value = np.arange(10.0), np.arange(10.0) ** 2
    assert envelope(time, value, 100)[1].tolist() == value.tolist()


@pytest.mark.parametrize("columns", [10, 10_000])
def test_gaps_interrupt_the_line(columns: int):
    time = np.concatenate([np.arange(500), np.arange(700, 1000)]) * 1.0
    times, values = envelope(time, time, columns, longest_interval=1.5)
    (gap,) = np.flatnonzero(np.isnan(values))
    assert times[gap - 1] == 499
    assert times[gap + 1] == 700


def test_a_single_time():
    assert envelope(np.zeros(9), np.arange(9.0), 1)[1].tolist() == [0.0, 8.0]


def test_nothing():
    assert envelope(np.empty(0), np.empty(0), 10)[0].size == 0
