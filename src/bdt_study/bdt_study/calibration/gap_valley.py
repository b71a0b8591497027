"""Fits that begin beside the best one, where the gap and other constants make up for each other.

A gap that is wider and a reading that is less late are nearly the same to a motor that reverses
always alike. Along such a valley the likelihood is rough, for contacts begin and end at samples: a
fit stays where it came to the valley, sure of a place in which it is by chance.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_study.calibration.fitted_data import SETTINGS
from bdt_study.calibration.prior_knowledge import is_plausible
from bdt_study.calibration.segment_covariance import segment_covariance
from bdt_study.calibration.whole_fit import fit_machine_noise
from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import MachineKnowledge
from bdt_twin.output_error_fit import WindowFit

FloatArray = NDArray[np.float64]

ASIDE = 4.0
"""Standard uncertainties of the gap by which the other fits begin beside it."""
GAIN = 0.2
"""Gain of log-likelihood for which another fit takes the place of the best one."""
STANDARD_LOSS = 0.5
"""Loss of log-likelihood by a standard deviation; what loses less is as far off at least."""
MOST_MOVES = 4
"""How often the best fit may be another one."""


def best_of_valley(window: CalibrationWindow, fit: Fit, known: MachineKnowledge) -> Fit:
    """Return the best fit in the valley of another one, with the covariance of its unknowns.

    Parameters
    ----------
    window : CalibrationWindow
        Model and data.
    fit : Fit
        Where a fit of them ended.
    known : MachineKnowledge
        What is known of the machine before.

    Returns
    -------
    Fit
        As unsure as parts of the data disagree, or as another fit says that is far off for the
        log-likelihood which it loses.
    """
    fit = fit.with_covariance(segment_covariance(window, fit))
    reversals = window.reversals(fit.responses)
    if not reversals:
        return fit
    weights = window.weights(np.array([reversals[-1]]))[:, 0]
    problem = WindowFit(window, SETTINGS.growth_change, known)
    for _ in range(MOST_MOVES):
        beside = [_fit_beside(problem, fit, weights, side) for side in (-ASIDE, ASIDE)]
        others = [each for each in beside if is_plausible(each, known)]
        best = min(others or [fit], key=lambda each: each.prediction_error)
        if best.gain_over(fit) < GAIN:
            break
        fit = best.with_covariance(segment_covariance(window, best))
    covariance = fit.covariance.copy()
    for other in others:
        difference = other.unknowns.as_vector() - fit.unknowns.as_vector()
        moved = float(weights @ difference[: weights.size])
        variance = moved * moved * STANDARD_LOSS / max(-other.gain_over(fit), STANDARD_LOSS)
        lacking = variance - _variance(covariance, weights)
        if lacking > 0.0:
            covariance += lacking * np.outer(difference, difference) / (moved * moved)
    return fit.with_covariance(covariance)


def _variance(covariance: FloatArray, weights: FloatArray) -> float:
    """Return the variance of a gap that lies between knots [rad^2]."""
    return float(weights @ covariance[: weights.size, : weights.size] @ weights)


def _fit_beside(problem: WindowFit, fit: Fit, weights: FloatArray, side: float) -> Fit:
    """Return the fit that begins some standard uncertainties beside, with all that goes with it.

    Parameters
    ----------
    problem : WindowFit
        What is to be solved.
    fit : Fit
        Where it was.
    weights : ndarray, shape (knots,)
        What the gap is at the knots that is moved.
    side : float
        By how many standard uncertainties.
    """
    along = fit.covariance[:, : weights.size] @ weights
    step = side * along / math.sqrt(_variance(fit.covariance, weights))
    moved = fit.unknowns.from_vector(fit.unknowns.as_vector() + step)
    return fit_machine_noise(problem, replace(fit, unknowns=moved))
