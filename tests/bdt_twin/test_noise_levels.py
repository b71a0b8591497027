"""Levels of noise, found by the likelihood of simulated residuals."""

import math
from itertools import pairwise

import numpy as np
import pytest
from machine_noise import LEVELS, random_motion, simulated, whitening

from bdt_twin.innovations import NoiseLevels
from bdt_twin.noise_levels import (
    EXPLAINED,
    NOTHING,
    QUIETER,
    fitted_levels,
    is_noticed,
    is_restless,
    is_slight,
    is_walking,
    quiet,
    robust_deviation,
)


def found_levels(motion, levels, seed, first=None):
    residual = simulated(motion, levels, seed)
    return fitted_levels(
        lambda tried: whitening([motion], tried, residual),
        residual,
        NoiseLevels(3e-6, 3e-6, 3e-6, 3e-6) if first is None else first,
        100,
    )


@pytest.mark.parametrize("seed", range(2))
def test_levels_are_found_by_their_likelihood(seed):
    found = found_levels(random_motion(4000, seed), LEVELS, seed)
    for level, true in zip(found.levels, LEVELS, strict=True):
        assert true / 3.0 < level < true * 3.0
    made = whitening([random_motion(4000, seed)], LEVELS, np.zeros(4000))
    best = math.exp(np.log(made.deviations).mean())
    assert found.prediction_error == pytest.approx(best, rel=0.05)


def test_no_level_is_found_where_there_is_none():
    true = NoiseLevels(2e-6)
    found = found_levels(random_motion(3000), true, 1, NoiseLevels(3e-6))
    assert found.levels[1:] == (0.0, 0.0, 0.0)
    assert found.levels.reading == pytest.approx(2e-6, rel=0.06)
    assert found.prediction_error == pytest.approx(2e-6, rel=0.06)


def test_levels_that_are_not_there_any_more_are_given_up_until_they_do_not_matter():
    motion = random_motion(3000)
    found = found_levels(motion, NoiseLevels(2e-6), 1, LEVELS)
    assert found.levels.reading == pytest.approx(2e-6, rel=0.06)
    made = whitening([motion], found.levels, np.zeros(3000))
    assert np.median(made.deviations) < 1.05 * found.levels.reading


@pytest.mark.parametrize("which", ["fast", "slow", "force"])
def test_one_kind_of_noise_is_not_taken_for_another(which):
    levels = NoiseLevels(1e-6)._replace(**{which: getattr(LEVELS, which)})
    found = found_levels(random_motion(4000), levels, 2).levels
    assert getattr(found, which) == pytest.approx(getattr(levels, which), rel=0.8)
    for other in {"fast", "slow", "force"} - {which}:
        assert getattr(found, other) < 0.3 * getattr(LEVELS, other)


def test_one_try_finds_the_scale_and_keeps_the_ratios():
    motion = random_motion(3000)
    residual = simulated(motion, LEVELS, 3)
    tenth = NoiseLevels(*(0.1 * level for level in LEVELS))
    found = fitted_levels(lambda tried: whitening([motion], tried, residual), residual, tenth, 1)
    for level, true in zip(found.levels, LEVELS, strict=True):
        assert level == pytest.approx(true, rel=0.06)


def test_more_tries_never_make_a_residual_less_likely():
    motion = random_motion(1000)
    residual = simulated(motion, LEVELS, 6)

    def make(tried):
        return whitening([motion], tried, residual)

    errors = [
        fitted_levels(make, residual, NoiseLevels(1e-5), most).prediction_error
        for most in (1, 2, 5, 10, 40)
    ]
    assert all(later <= earlier for earlier, later in pairwise(errors))
    assert errors[-1] < errors[0]


def test_outliers_hardly_change_the_robust_deviation():
    values = np.random.default_rng(0).normal(scale=2.0, size=20000)
    assert robust_deviation(values) == pytest.approx(2.0, rel=0.03)
    values[::100] = 1e6
    assert robust_deviation(values) == pytest.approx(2.0, rel=0.08)
    assert robust_deviation(np.zeros(5)) > 0.0


def test_no_walk_is_found_smaller_than_the_least():
    residual, motion = np.random.default_rng(3).normal(scale=2e-6, size=3000), random_motion(3000)
    found = fitted_levels(
        lambda tried: whitening([motion], tried, residual),
        residual,
        NoiseLevels(3e-6, 0.0, 1e-5, 0.0),
        100,
        1e-6,
    )
    assert found.levels.slow == pytest.approx(1e-6)
    assert found.levels.reading == pytest.approx(2e-6, rel=0.06)


def test_a_motor_that_is_made_quiet_walks_less_or_not_at_all():
    levels = NoiseLevels(1e-6, 1e-4, 1e-7, 3e-6)
    assert is_restless(levels)
    made = quiet(levels)
    assert made.fast == levels.fast / QUIETER
    assert made.slow == 0.0
    assert made._replace(fast=levels.fast, slow=levels.slow) == levels
    assert not is_restless(NoiseLevels(1e-6, 1e-6, 1e-6, 1e-3))


@pytest.mark.parametrize("walk", ["fast", "slow"])
def test_a_slight_walk_is_none_of_a_motor_that_is_made_quiet(walk):
    most = NoiseLevels(1e-6)._replace(**{walk: QUIETER * NOTHING * 1e-6})
    assert is_slight(most)
    assert not is_slight(most._replace(**{walk: 1.01 * getattr(most, walk)}))
    assert is_slight(NoiseLevels(1e-6, force=1e-3))


@pytest.mark.parametrize("walk", ["fast", "slow"])
def test_a_walk_is_noticed_beside_the_noise_of_a_reading_and_a_force_always(walk):
    most = NoiseLevels(1e-6)._replace(**{walk: NOTHING * 1e-6})
    assert not is_noticed(most)
    assert is_noticed(most._replace(**{walk: 1.01 * getattr(most, walk)}))
    assert is_noticed(NoiseLevels(1e-6, force=1e-9))


def test_a_walk_counts_if_it_is_more_than_noise_and_than_what_a_good_model_leaves_out():
    motion = 5e-3
    small, large = 0.9 * EXPLAINED * motion, 1.1 * EXPLAINED * motion
    assert is_walking(NoiseLevels(1e-8, 0.0, large, 0.0), motion)
    assert not is_walking(NoiseLevels(1e-8, small, small, 1.0), motion)
    assert not is_walking(NoiseLevels(large, large, large, 0.0), motion)
