"""Fits beside the best one take its place, or say how unsure the gap is."""

import math
from dataclasses import replace

import numpy as np
import pytest
from recorded_machine import Run, record
from unknown_machine import UnknownMachine

from bdt_plant.plant import PlantModel
from bdt_study.calibration import gap_valley as module
from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_study.calibration.gap_valley import MOST_MOVES, best_of_valley
from bdt_study.calibration.prior_knowledge import wide_knowledge
from bdt_study.calibration.segment_covariance import segment_covariance
from bdt_twin.output_error_fit import WindowFit
from bdt_twin.stretch import Stretch
from bdt_twin.window_search import multi_start

RATE, BLOCK = 1000.0, 5
KNOWN = wide_knowledge(0.0)
DEGREE = math.radians(1.0)
FAR_OFF = -8.0
"""Gain of what is four standard deviations off."""


@pytest.fixture(scope="module")
def fitted():
    """Return a window and its fit."""
    rows, _ = record(UnknownMachine(), Run(duration=12.0, sampling_rate=RATE, step_time=3.0))
    stretch = Stretch(0, *np.ascontiguousarray(rows[:, 1:].T))
    window = CalibrationWindow(PlantModel(), [stretch], np.arange(13.0), RATE, BLOCK)
    begun = multi_start(window, DEGREE, KNOWN)
    fit = WindowFit(window, DEGREE, KNOWN).solve(begun.unknowns, 12, 36, levels=begun.levels)
    return window, fit


def last_gap(window, fit):
    """Return the gap that the last reversal tells, and its standard uncertainty [rad]."""
    weights = window.weights(np.array([window.reversals(fit.responses)[-1]]))[:, 0]
    variance = weights @ fit.gap_covariance @ weights
    return weights @ fit.unknowns.gaps, math.sqrt(variance)


def beside(monkeypatch, fit, gains, wider=DEGREE):
    """Let fits beside the best one gain so much log-likelihood, each with a wider gap."""
    waiting = iter(gains)

    def found(problem, best, weights, side):
        gain = next(waiting)
        error = best.prediction_error * math.exp(-gain / fit.innovations.size)
        unknowns = replace(best.unknowns, gaps=best.unknowns.gaps + math.copysign(wider, side))
        return replace(best, unknowns=unknowns, prediction_error=error)

    monkeypatch.setattr(module, "_fit_beside", found)


def test_a_gap_is_as_unsure_as_its_data_disagree_where_others_lose_what_they_should(
    monkeypatch, fitted
):
    window, fit = fitted
    beside(monkeypatch, fit, [FAR_OFF] * 2, wider=1e-5)
    found = best_of_valley(window, fit, KNOWN)
    assert found.unknowns is fit.unknowns
    assert np.array_equal(found.covariance, segment_covariance(window, fit))


@pytest.mark.parametrize(("loss", "share"), [(0.0, 1.0), (0.5, 1.0), (2.0, 0.5), (8.0, 0.25)])
def test_a_gap_is_as_unsure_as_one_is_far_that_loses_little(monkeypatch, fitted, loss, share):
    window, fit = fitted
    beside(monkeypatch, fit, [-loss, -1e6])
    found = best_of_valley(window, fit, KNOWN)
    _, uncertainty = last_gap(window, found)
    assert last_gap(window, fit)[1] < 0.1 * DEGREE
    assert uncertainty == pytest.approx(share * DEGREE, rel=1e-3)


def test_a_better_fit_takes_the_place_of_the_best_one(monkeypatch, fitted):
    window, fit = fitted
    beside(monkeypatch, fit, [-1e6, 1.0, *[-1e6] * 2])
    found = best_of_valley(window, fit, KNOWN)
    assert last_gap(window, found)[0] == pytest.approx(last_gap(window, fit)[0] + DEGREE)


def test_a_valley_without_an_end_is_left(monkeypatch, fitted):
    window, fit = fitted
    beside(monkeypatch, fit, [-1e6, 1.0] * MOST_MOVES)
    moved = last_gap(window, best_of_valley(window, fit, KNOWN))[0] - last_gap(window, fit)[0]
    assert moved == pytest.approx(MOST_MOVES * DEGREE)


def test_a_machine_that_is_none_is_not_taken(monkeypatch, fitted):
    window, fit = fitted
    monkeypatch.setattr(module, "is_plausible", lambda *_: False)
    beside(monkeypatch, fit, [1.0, 1.0])
    assert best_of_valley(window, fit, KNOWN).unknowns is fit.unknowns


def test_fits_begin_on_both_sides_and_come_back_to_where_the_gap_is_certain(fitted):
    window, fit = fitted
    gap, uncertainty = last_gap(window, best_of_valley(window, fit, KNOWN))
    assert gap == pytest.approx(last_gap(window, fit)[0], abs=3.0 * uncertainty)
    assert uncertainty < 0.1 * DEGREE
