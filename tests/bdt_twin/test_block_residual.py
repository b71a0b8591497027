"""Means of blocks without outliers; how slow a residual is."""

import numpy as np
import pytest

from bdt_twin.block_residual import BlockResidual, inliers, variance_inflation
from bdt_twin.stretch import Stretch


def stretch_of(position):
    return Stretch(0, np.zeros(position.size), position)


def test_means_are_those_of_the_blocks():
    positions, simulated = np.random.default_rng(0).normal(size=(2, 100))
    residual = BlockResidual([stretch_of(positions[:40]), stretch_of(positions[40:])], 5)
    found = residual.means([simulated[:40], simulated[40:]])
    assert found == pytest.approx((positions - simulated).reshape(-1, 5).mean(axis=1))


def test_an_outlier_does_not_move_the_mean_of_its_block():
    position = np.random.default_rng(1).normal(size=500)
    position[107] = 1000.0
    residual = BlockResidual([stretch_of(position)], 25)
    found = residual.means([np.zeros(500)])
    others = np.delete(position[100:125], 7)
    assert found[4] == pytest.approx(others.mean())


def test_outliers_may_be_nearly_half_of_a_block():
    position = np.random.default_rng(2).normal(size=500)
    position[101:125:2] += 1000.0 * np.arange(1, 13)
    residual = BlockResidual([stretch_of(position)], 25)
    assert residual.means([np.zeros(500)])[4] == pytest.approx(position[100:125:2].mean())


def test_readings_are_screened_one_by_one_where_their_means_are_simulated():
    """A position that a simulation of means explains, read with noise and an outlier."""
    times = np.arange(500.0)
    motion = 1e-2 * times + 1e-6 * np.square(times)
    readings = motion + np.random.default_rng(3).normal(size=500)
    readings[107] = 1000.0
    stretch = stretch_of(readings).averaged(5, 5)
    simulated = motion.reshape(-1, 5).mean(axis=1)
    found = BlockResidual([stretch], 5).means([simulated])
    good = np.delete(np.arange(100, 125), 7)
    assert found[4] == pytest.approx((readings - motion)[good].mean(), abs=1e-5)
    assert found[5] == pytest.approx((readings - motion)[125:150].mean(), abs=1e-5)


def test_another_simulation_is_compared_with_the_same_readings():
    readings, first, second = np.random.default_rng(6).normal(size=(3, 100))
    residual = BlockResidual([stretch_of(readings)], 5)
    change = residual.means([first]) - residual.means([second])
    assert change == pytest.approx((second - first).reshape(-1, 5).mean(axis=1))


def test_normal_noise_has_no_outliers():
    assert inliers(np.random.default_rng(3).normal(size=(4000, 25))).all()


@pytest.mark.parametrize("samples", [5, 6, 25, 50])
def test_outliers_are_those_beyond_twelve_median_deviations(samples):
    residual = np.random.default_rng(4).standard_cauchy(size=(400, samples))
    distance = np.abs(residual - np.median(residual, axis=1, keepdims=True))
    spread = np.median(distance, axis=1, keepdims=True)
    expected = distance <= 12.0 * np.maximum(spread, spread.mean())
    assert not expected.all()
    assert (inliers(residual) == expected).all()


def test_blocks_of_few_samples_are_not_screened():
    assert inliers(np.array([[0.0, 0.0, 1e9, 0.0]])).all()


def test_white_noise_counts_in_full():
    assert variance_inflation(np.random.default_rng(4).normal(size=4000), 20.0) < 1.3


def test_correlated_noise_counts_as_the_mean_of_it_varies():
    """An autoregression x[n] = a x[n-1] + w[n]: the factor is (1 + a) / (1 - a)."""
    white, noise = np.random.default_rng(5).normal(size=200_000), np.zeros(200_000)
    for n in range(1, noise.size):
        noise[n] = 0.8 * noise[n - 1] + white[n]
    assert variance_inflation(noise, 200.0) == pytest.approx(9.0, rel=0.1)


def test_a_residual_of_zeros_is_white():
    assert variance_inflation(np.zeros(100), 200.0) == 1.0
