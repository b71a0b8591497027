"""Waves beside a fit, against the joint fit of both, and doubts in closed form."""

import math
from functools import cache

import numpy as np
import pytest
from fitted_machine import last_fit_of_machine
from recorded_machine import Run
from unknown_machine import UnknownMachine

from bdt_twin.cogging_waves import NUMBERS, wave_slopes
from bdt_twin.fit_doubt import covariance_inflation, huber_weights
from bdt_twin.machine_knowledge import COGGING
from bdt_twin.model_factors import FACTORS
from bdt_twin.wave_problem import TIGHTNESS, WaveFits, WaveProblem


@cache
def fit_of(cogging):
    """Return window and fit of a machine with some cogging [N m], 24 periods in a turn."""
    machine = UnknownMachine(coulomb_friction=0.02, cogging=cogging)
    last = last_fit_of_machine(machine, Run(duration=20.0, step_time=3.0))
    return last.window, last.fit


def joint_fit(window, fit, cogs):
    """Return the gain by a wave and how it moves the unknowns, by normal equations of all."""
    first = window.knots.size + len(FACTORS)
    cogging = [first + effect for effect in sorted(COGGING)]
    others = [place for place in range(len(fit.prior)) if place not in cogging]
    slopes = fit.whitening.apply(window.jacobian(fit.unknowns, fit.responses))
    waves = fit.whitening.apply(wave_slopes(window, fit))
    place = 2 * NUMBERS.index(cogs)
    weights = huber_weights(fit.innovations) / covariance_inflation(
        fit.innovations, fit.levels, window.block_rate
    )
    pulled = (slopes * weights) @ fit.innovations - (
        (slopes * weights) @ slopes.T + fit.prior
    ) @ fit.pending
    without = fit.innovations + fit.unknowns.as_vector()[cogging] @ slopes[cogging]
    rows = np.vstack([slopes[others], waves[place : place + 2]])
    information, count = (rows * weights) @ rows.T, len(others)
    information[:count, :count] += fit.prior[np.ix_(others, others)]
    information[count:, count:] += TIGHTNESS * np.eye(2)
    slope = rows @ (weights * without) - np.append(pulled[others], [0.0, 0.0])
    alone = np.linalg.solve(information[:count, :count], slope[:count])
    jointly = np.linalg.solve(information, slope)
    return (
        0.5 * (slope @ jointly - slope[:count] @ alone),
        jointly[:count] - alone,
        jointly[count:],
    )


@pytest.mark.parametrize("cogging", [0.0, 3e-3])
@pytest.mark.parametrize("cogs", [4, 23, 24, 48])
def test_a_wave_beside_a_fit_is_that_of_the_joint_fit(cogging, cogs):
    window, fit = fit_of(cogging)
    fits, place = WaveProblem(window, fit).fits(fit.levels), NUMBERS.index(cogs)
    gain, moved, sizes = joint_fit(window, fit, cogs)
    assert fits.gains[place] == pytest.approx(gain, rel=1e-4, abs=1e-6)
    knots = window.knots.size
    # The gaps are what matters; other unknowns differ by many orders of magnitude.
    found = (fits.moves[:, :, place] @ sizes)[:knots]
    assert found == pytest.approx(moved[:knots], rel=1e-3, abs=1e-9)


def test_the_cogging_of_a_fit_counts_for_nothing_known():
    window, fit = fit_of(3e-3)
    assert window.cogs == 24
    gains = WaveProblem(window, fit).fits(fit.levels).gains
    assert NUMBERS[int(gains.argmax())] == 24
    assert gains.max() > 20.0
    window, fit = fit_of(0.0)
    assert WaveProblem(window, fit).fits(fit.levels).gains.max() < 8.0


def fits_of(slopes, information, moves):
    """Return fits of waves whose parts tell nothing about each other."""
    slopes, information = np.array(slopes, dtype=float), np.array(information, dtype=float)
    moves = np.array(moves, dtype=float)
    return WaveFits(information, 0.0 * information, information, slopes, moves)


def test_doubt_of_one_wave_is_how_it_moves_and_how_unsure_its_size_is():
    fits = fits_of([[30.0], [40.0]], [1000.0], [[[2.0], [0.5]]])
    moved = 2.0 * 0.03 + 0.5 * 0.04
    variance = (2.0**2 + 0.5**2) / 1000.0
    assert fits.doubt(np.array([1.0])) == pytest.approx(math.sqrt(moved**2 + variance))
    assert fits.doubt(np.array([-3.0])) == pytest.approx(3.0 * math.sqrt(moved**2 + variance))


def test_waves_count_by_what_they_explain_with_all_sizes_that_they_may_have():
    slopes, information = [[10.0, 60.0], [0.0, 0.0]], [500.0, 2000.0]
    fits = fits_of(slopes, information, [[[1.0, -3.0], [0.0, 0.0]]])
    squares = [(10.0 / 500.0) ** 2 + 1 / 500.0, 9.0 * ((60.0 / 2000.0) ** 2 + 1 / 2000.0)]
    # Of a normal likelihood, with the same prior of both: exp(gain) / sqrt(determinant).
    likely = [math.exp(0.5 * 100.0 / 500.0) / 500.0, math.exp(0.5 * 3600.0 / 2000.0) / 2000.0]
    expected = math.sqrt(np.dot(likely, squares) / sum(likely))
    assert fits.doubt(np.array([1.0])) == pytest.approx(expected, rel=1e-12)
