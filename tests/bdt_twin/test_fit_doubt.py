"""What makes a fit less sure: newest data that it does not explain."""

import numpy as np
import pytest

from bdt_twin.fit_doubt import NEWEST, is_surprised
from bdt_twin.innovations import NoiseLevels

QUIET = NoiseLevels(1e-6)
WALKING = NoiseLevels(1e-6, 1e-5, 1e-6, 0.0)
RATES = [10.0, 50.0, 200.0]


def innovations(rate, seed=1):
    return np.random.default_rng(seed).normal(size=round(20.0 * rate))


@pytest.mark.parametrize("rate", RATES)
def test_noise_surprises_no_oftener_than_three_standard_deviations(rate):
    surprised = [is_surprised(innovations(rate, seed), QUIET, rate) for seed in range(500)]
    assert np.mean(surprised) < 0.02


@pytest.mark.parametrize("rate", RATES)
def test_newest_innovations_that_are_twice_as_large_surprise(rate):
    newest = innovations(rate)
    newest[-round(NEWEST * rate) :] *= 2.0
    assert is_surprised(newest, QUIET, rate)
    assert not is_surprised(newest, WALKING, rate)


@pytest.mark.parametrize("rate", RATES)
def test_older_ones_do_not(rate):
    older = innovations(rate)
    older[: -round(NEWEST * rate)] *= 2.0
    assert not is_surprised(older, QUIET, rate)


def test_a_single_outlier_does_not():
    outlier = innovations(200.0)
    outlier[-10] = 1e3
    assert not is_surprised(outlier, QUIET, 200.0)


def test_what_is_negligible_does_not_however_small_the_noise_is():
    newest = innovations(200.0)
    newest[-200:] *= 2.0
    assert is_surprised(newest, QUIET, 200.0, negligible=1.0)
    assert not is_surprised(newest, QUIET, 200.0, negligible=3.0)
