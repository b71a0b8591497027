"""Why a fit is less sure than its residual would be if it were white noise.

What is left in the innovations that is not white says less than they are many, and a short window
has seen too little of what it cannot explain.
"""

import math

import numpy as np
from numpy.typing import NDArray

from bdt_twin.block_residual import variance_inflation
from bdt_twin.fixed_order import mean
from bdt_twin.innovations import NoiseLevels
from bdt_twin.noise_levels import HUBER, is_noticed, is_restless
from bdt_twin.robust_sums import bounded_mean_square

FloatArray = NDArray[np.float64]

LITTLE_DOUBT, RESTLESS_DOUBT = 1.3, 1.1
"""Factors by which uncertainties are larger where a machine has a little noise, and where its motor
walks a lot: the levels are found from the same data, and small ones are hardly told from none."""
SHORT, SHORT_AND_RESTLESS = 3.0, 8.0
"""Time [s] in which a window has seen too little to know what it cannot explain, and the same where
the motor walks a lot."""
FIRST_MOTIONS = 6.0
"""Time [s] from a machine's first motion on in which it goes there and perhaps back: too little to
tell what the model has not from a gap."""
FIRST_DOUBT = 1.4
"""Factor by which the gap is less sure until then."""

NEWEST = 1.0
"""Time before the end of a window [s] in which a fit of the data before meets something new."""
SURPRISE = 3.0
"""Standard deviations of the mean square of white noise by which that of the newest innovations
exceeds its mean, if they are no noise."""
LONGEST_PUSH = 0.25
"""Time for which something pushes a platform [s]; what goes on for longer is a wrong model."""


def is_surprised(
    innovations: FloatArray,
    pushed: FloatArray,
    levels: NoiseLevels,
    rate: float,
    negligible: float = 0.0,
) -> bool:
    """Return whether the newest data are explained worse than noise and a push would have it.

    A motor that walks a lot surprises now and then.

    Parameters
    ----------
    innovations : ndarray, shape (blocks,)
        Innovations over their standard deviations.
    pushed : ndarray, shape (blocks,)
        One where something pushed a platform, else zero.
    levels : NoiseLevels
        Levels of noise.
    rate : float
        Blocks in a second [Hz].
    negligible : float
        Root mean square that is as good as none, however small the noise is.
    """
    count = max(round(NEWEST * rate), 1)
    newest, pushes = innovations[-count:], np.flatnonzero(pushed[-count:])
    if is_restless(levels) or mean(np.square(newest)) < negligible * negligible:
        return False
    if pushes.size and np.ptp(pushes) > LONGEST_PUSH * rate:
        return True
    return excess(newest) > SURPRISE


def excess(innovations: FloatArray) -> float:
    """Return by how much innovations are larger than noise.

    Parameters
    ----------
    innovations : ndarray, shape (n,)
        Innovations over their standard deviations.

    Returns
    -------
    float
        What their mean square exceeds 1 by, in standard deviations of that of white noise.
    """
    return (bounded_mean_square(innovations, HUBER) - 1.0) / math.sqrt(2.0 / innovations.size)


def huber_weights(innovations: FloatArray) -> FloatArray:
    """Return the weights that make squares out of Huber's loss."""
    weights: FloatArray = HUBER / np.maximum(np.abs(innovations), HUBER)
    return weights


def doubted_weights(innovations: FloatArray, levels: NoiseLevels, rate: float) -> FloatArray:
    """Return the weights of squares whose information is as sure as a fit is.

    Parameters
    ----------
    innovations, levels, rate
        As :func:`covariance_inflation` takes them.
    """
    inflation = covariance_inflation(innovations, levels, rate)
    weights: FloatArray = huber_weights(innovations) / inflation
    return weights


def covariance_inflation(innovations: FloatArray, levels: NoiseLevels, rate: float) -> float:
    """Return by how many times the covariance of a fit exceeds that of white innovations.

    Parameters
    ----------
    innovations : ndarray, shape (blocks,)
        Innovations over their standard deviations.
    levels : NoiseLevels
        Levels of noise.
    rate : float
        Blocks in a second [Hz].
    """
    bounded = np.clip(innovations, -HUBER, HUBER)
    inflation = variance_inflation(bounded, rate) * max(
        1.0, bounded_mean_square(innovations, HUBER)
    )
    time, short, doubt = innovations.size / rate, SHORT, 1.0
    if is_restless(levels):
        short, doubt = SHORT_AND_RESTLESS, RESTLESS_DOUBT
    elif is_noticed(levels):
        doubt = LITTLE_DOUBT
    inflation *= doubt * doubt
    return inflation * (1.0 + (short / time) * (short / time))
