"""Covariance of a fit from how much the parts of the data disagree.

A fit is as sure as its residual is white. What is wrong with the model is not: friction that
depends on speed pulls one way in slow motion, and the other way in fast motion. So the slope of the
likelihood, which is zero over all data, is not zero in each segment of them, and by how much it
varies tells how far the constants would move with other motions (the sandwich of Huber and White,
with segments in place of samples).

References
----------
H. White, Maximum likelihood estimation of misspecified models, Econometrica 50 (1982), 1-25.
"""

import numpy as np
from numpy.typing import NDArray

from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_twin.fit_doubt import doubted_weights
from bdt_twin.fit_result import Fit

FloatArray = NDArray[np.float64]

SEGMENT = 2.5
"""Length of a segment [s]."""


def segment_covariance(window: CalibrationWindow, fit: Fit) -> FloatArray:
    """Return the covariance of all unknowns of a fit, never smaller than the fit's own.

    Parameters
    ----------
    window : CalibrationWindow
        Model and data.
    fit : Fit
        The fit.
    """
    jacobian = fit.whitening.apply(window.jacobian(fit.unknowns, fit.responses))
    weights = doubted_weights(fit.innovations, fit.levels, window.block_rate)
    # The slope that belongs to the information behind the fit's covariance.
    slopes = jacobian * (weights * fit.innovations)
    length = max(round(SEGMENT * window.block_rate), 1)
    sums = np.add.reduceat(slopes, np.arange(0, slopes.shape[1], length), axis=1)
    sums -= sums.mean(axis=1, keepdims=True)
    moved = fit.covariance @ sums
    sandwich = np.sum(np.square(moved), axis=1) * sums.shape[1] / max(sums.shape[1] - 1, 1)
    wider = np.sqrt(np.maximum(sandwich / np.diag(fit.covariance), 1.0))
    covariance: FloatArray = fit.covariance * np.outer(wider, wider)
    return covariance
