"""Probabilities in cells: counted by hand, with intervals that cover what they promise."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, binomtest

from bdt_study.sweep.cells import BINS, binned, clopper_pearson, means_of, shares_of
from bdt_study.sweep.margins import margin_of


@given(st.integers(0, 200).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_an_interval_is_that_of_scipy(case):
    hits, count = case
    low, high = clopper_pearson(np.array([hits]), np.array([count]))
    if not count:
        assert (low[0], high[0]) == (0.0, 1.0)
        return
    expected = binomtest(hits, count).proportion_ci(0.95, method="exact")
    assert (low[0], high[0]) == pytest.approx((expected.low, expected.high), abs=1e-9)


@pytest.mark.parametrize("probability", [0.01, 0.2, 0.5])
def test_an_interval_covers_the_truth_at_least_as_often_as_it_says(probability):
    hits = np.arange(41)
    low, high = clopper_pearson(hits, np.full(41, 40))
    covers = (low <= probability) & (probability <= high)
    assert binom.pmf(hits[covers], 40, probability).sum() >= 0.95


def test_runs_are_counted_in_their_cells_and_unknown_ones_nowhere():
    happened = np.array([1.0, 0.0, np.nan, 1.0, 1.0])
    right = np.array([0, 0, 0, 1, 1])
    up = np.array([0, 0, 0, 2, 2])
    shares = shares_of(happened, up, right, shape=(3, 2))
    assert shares.counts.tolist() == [[2, 0], [0, 0], [0, 2]]
    assert shares.shares[0, 0] == 0.5
    assert shares.shares[2, 1] == 1.0
    assert np.isnan(shares.shares[1, 0])
    means = means_of(10.0 * happened, right, shape=(2,))
    assert means.tolist() == [5.0, 10.0]


def test_few_values_are_cells_of_their_own_and_many_are_put_into_bins():
    values, places = binned(np.array([0.3, 0.1, 0.3]))
    assert (values.tolist(), places.tolist()) == ([0.1, 0.3], [1, 0, 1])
    many = np.linspace(0.0, 2.0, 1001)
    values, places = binned(many)
    assert values.size == BINS
    assert np.abs(values[places] - many).max() <= 0.5 * 2.0 / BINS + 1e-12


def test_a_margin_reaches_to_the_first_value_that_is_unsafe_on_either_side():
    values = np.arange(6.0)
    hits = np.array([1, 0, 0, 0, 1, 0])
    shares = shares_of(hits.astype(float), np.arange(6), shape=(6,))
    found = margin_of("a.b", 2.2, values, shares)
    assert (found.lowest, found.highest) == (1.0, 3.0)
    assert (found.reaches_low, found.reaches_high) == (False, False)
    beyond = margin_of("a.b", 5.0, values, shares)
    assert (beyond.lowest, beyond.highest, beyond.reaches_high) == (5.0, 5.0, True)
    assert margin_of("a.b", 4.0, values, shares).lowest is None
