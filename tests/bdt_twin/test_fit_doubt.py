"""What makes a fit less sure: noise of the machine, and newest data that it does not explain."""

import numpy as np
import pytest

from bdt_twin.fit_doubt import LITTLE_DOUBT, NEWEST, covariance_inflation, is_surprised
from bdt_twin.innovations import NoiseLevels

QUIET = NoiseLevels(1e-6)
WALKING = NoiseLevels(1e-6, 1e-5, 1e-6, 0.0)
RATES = [10.0, 50.0, 200.0]


def innovations(rate, seed=1):
    return np.random.default_rng(seed).normal(size=round(20.0 * rate))


def surprised_by(innovations, levels, rate, pushes=(), **rest):
    """Tell whether a window is surprising in which something pushed some blocks from its end."""
    pushed = np.zeros(innovations.size)
    pushed[[-number for number in pushes]] = 1.0
    return is_surprised(innovations, pushed, levels, rate, **rest)


@pytest.mark.parametrize("rate", RATES)
def test_noise_surprises_no_oftener_than_three_standard_deviations(rate):
    surprised = [surprised_by(innovations(rate, seed), QUIET, rate) for seed in range(500)]
    assert np.mean(surprised) < 0.02


@pytest.mark.parametrize("rate", RATES)
def test_newest_innovations_that_are_twice_as_large_surprise(rate):
    newest = innovations(rate)
    newest[-round(NEWEST * rate) :] *= 2.0
    assert surprised_by(newest, QUIET, rate)
    assert not surprised_by(newest, WALKING, rate)


@pytest.mark.parametrize("rate", RATES)
def test_older_ones_do_not(rate):
    older = innovations(rate)
    older[: -round(NEWEST * rate)] *= 2.0
    assert not surprised_by(older, QUIET, rate)


def test_a_single_outlier_does_not():
    outlier = innovations(200.0)
    outlier[-10] = 1e3
    assert not surprised_by(outlier, QUIET, 200.0)


def test_what_is_negligible_does_not_however_small_the_noise_is():
    newest = innovations(200.0)
    newest[-200:] *= 2.0
    assert surprised_by(newest, QUIET, 200.0, negligible=1.0)
    assert not surprised_by(newest, QUIET, 200.0, negligible=3.0)


@pytest.mark.parametrize("rate", [50.0, 125.0, 200.0])
def test_a_push_does_not_surprise_but_one_that_goes_on_and_on_does(rate):
    newest, period = innovations(rate), round(0.05 * rate)
    once = range(period, round(0.2 * rate))
    again_and_again = range(period, round(0.6 * rate), period)
    assert not surprised_by(newest, QUIET, rate, once)
    assert surprised_by(newest, QUIET, rate, again_and_again)
    assert not surprised_by(newest, WALKING, rate, again_and_again)
    before = [round(NEWEST * rate) + number for number in again_and_again]
    assert not surprised_by(newest, QUIET, rate, before)


def test_a_little_noise_of_the_machine_makes_less_sure_and_none_does_not():
    values = innovations(125.0)
    none = covariance_inflation(values, QUIET, 125.0)
    # What the friction of a motor that has next to none lets it walk.
    next_to_none = covariance_inflation(values, QUIET._replace(slow=1e-18), 125.0)
    little = covariance_inflation(values, QUIET._replace(slow=1e-7), 125.0)
    assert next_to_none == none
    assert little == pytest.approx(LITTLE_DOUBT**2 * none)
