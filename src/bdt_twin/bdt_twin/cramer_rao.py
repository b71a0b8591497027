"""Cramer-Rao bound of the gap: how well any unbiased estimator can know it from a window."""

import math

import numpy as np
from numpy.typing import NDArray

from bdt_twin.fixed_order import weighted_products
from bdt_twin.unknowns import Unknowns
from bdt_twin.window_model import WindowModel

FloatArray = NDArray[np.float64]

SMALLEST_SHARE = 1e-9
"""Share of the gap's information below which what is left beside the others is rounding."""


def fisher_information(jacobian: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the Fisher information of the unknowns from independent normal measurements.

    Parameters
    ----------
    jacobian : ndarray, shape (unknowns, measurements)
        Slopes of the measurements.
    weights : ndarray, shape (measurements,)
        Inverse variances.

    Returns
    -------
    ndarray, shape (unknowns, unknowns)
    """
    return weighted_products(jacobian, weights)


def cramer_rao_bound(window: WindowModel, unknowns: Unknowns, time: float, noise: float) -> float:
    """Return the smallest standard deviation of the gap at `time` [rad].

    Unknown beside the gap are its growth, even over the window, the factors on the model, and
    the beginning of each stretch. Nothing else is known about them, so an estimator that knows
    more, or one that is biased, may be better.

    Parameters
    ----------
    window : WindowModel
        Model and data; of the data only voltages and times count.
    unknowns : Unknowns
        True values.
    time : float
        Time of the gap [s].
    noise : float
        Standard deviation of the white noise of each sample of the position [m].

    Returns
    -------
    float
        Infinite if the window tells nothing about the gap.

    References
    ----------
    S. M. Kay, Fundamentals of Statistical Signal Processing: Estimation Theory, section 3.9.
    """
    jacobian = window.jacobian(unknowns, window.simulate(unknowns))
    knots = window.knots.size
    beginnings = knots + unknowns.factors.size + unknowns.effects.size
    # Gap and growth move all knots; effects that the mechanism has not are none of the unknowns.
    even = np.stack([np.ones(knots), window.knots - time])
    factors = jacobian[knots : knots + unknowns.factors.size]
    reduced = np.vstack([even @ jacobian[:knots], factors, jacobian[beginnings:]])
    weights = np.full(jacobian.shape[1], window.readings_per_block / noise**2)
    information = fisher_information(reduced, weights)
    scale = np.sqrt(np.diag(information))
    if scale[0] == 0.0:
        return math.inf
    # Rows without any information, as that of a motor that is in contact from the beginning, do
    # not take any from the gap.
    scale[scale == 0.0] = 1.0
    scaled = information / np.outer(scale, scale)
    others = scaled[1:, 1:]
    left = 1.0 - float(scaled[0, 1:] @ np.linalg.pinv(others, hermitian=True) @ scaled[1:, 0])
    return 1.0 / (float(scale[0]) * math.sqrt(left)) if left > SMALLEST_SHARE else math.inf
