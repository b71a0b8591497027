"""Sums over innovations against numpy, and against what they are defined by."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bdt_twin.robust_sums import bounded_mean_square, huber_loss, mean_logarithm, median

VALUES = arrays(np.float64, st.integers(1, 60), elements=st.floats(-1e6, 1e6))
BOUND = st.floats(1e-6, 1e6)


@given(VALUES)
def test_the_median_is_that_of_numpy(values):
    assert median(values) == np.median(values)


@given(VALUES, BOUND)
def test_a_value_beyond_the_bound_counts_as_the_bound(values, bound):
    expected = np.mean(np.clip(values, -bound, bound) ** 2)
    assert bounded_mean_square(values, bound) == pytest.approx(expected, rel=1e-12)


@given(st.floats(0.0, 1e3), st.floats(1e-3, 1e3))
def test_hubers_loss_is_half_a_square_and_goes_on_straight_beyond_the_bound(size, bound):
    within, beyond = min(size, bound), max(size - bound, 0.0)
    expected = 0.5 * within**2 + bound * beyond
    for value in (size, -size):
        assert huber_loss(np.array([value]), bound) == pytest.approx(expected, rel=1e-9, abs=1e-300)


@given(VALUES, BOUND)
def test_losses_add_up(values, bound):
    expected = sum(huber_loss(np.array([value]), bound) for value in values)
    assert huber_loss(values, bound) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("count", [1, 7, 8, 9, 100, 4000])
@pytest.mark.parametrize("typical", [1e-300, 1e-6, 1.0, 1e300])
def test_the_mean_of_logarithms_is_that_of_numpy(count, typical):
    spread = np.random.default_rng(count).normal(scale=2.0, size=count)
    values = np.exp(spread) * typical
    assert mean_logarithm(values) == pytest.approx(np.log(values).mean(), rel=1e-12, abs=1e-14)
