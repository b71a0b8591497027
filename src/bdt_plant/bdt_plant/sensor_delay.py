"""Age of a reading: the position some time ago, also between two samples.

Between samples the position is that of a cubic through four of them. For a sample time h its error
is at most h^4 / 24 times the fourth derivative of the position: picometers for the paper's tower at
5000 Hz, where a straight line between two samples is 20 nm off.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

ROUNDING = 1e-9
"""Fraction of a sample by which a delay may miss whole samples and still is them."""

Weights = tuple[float, float, float, float]


class DiscreteDelay(NamedTuple):
    """A delay at one sampling rate.

    Attributes
    ----------
    samples : int
        Age in whole samples, rounded down.
    is_between : bool
        Whether there is more to it: a part of a sample.
    weights : tuple of float
        What the positions `samples`, ... `samples` + 3 samples ago count.
    """

    samples: int
    is_between: bool
    weights: Weights


def discretize_delay(delay: float, sampling_rate: float) -> DiscreteDelay:
    """Return a delay [s] for samples at `sampling_rate` [Hz]."""
    age = delay * sampling_rate
    if abs(age - round(age)) <= ROUNDING * max(age, 1.0):
        return DiscreteDelay(round(age), False, (1.0, 0.0, 0.0, 0.0))
    samples = int(age)
    x = age - samples
    # The cubics that are one at one of the ages 0, 1, 2, 3 and zero at the others.
    weights = (
        (x - 1.0) * (x - 2.0) * (x - 3.0) / -6.0,
        x * (x - 2.0) * (x - 3.0) / 2.0,
        x * (x - 1.0) * (x - 3.0) / -2.0,
        x * (x - 1.0) * (x - 2.0) / 6.0,
    )
    return DiscreteDelay(samples, True, weights)


def delay_line(delay: DiscreteDelay) -> FloatArray:
    """Return what a sensor remembers before its first sample: the platform at rest at zero.

    Returns
    -------
    ndarray, shape (samples of delay,)
        Positions not yet read [m]; see :func:`delayed`.
    """
    return np.zeros(delay.samples)


def delayed(line: FloatArray, sample: int, position: float) -> float:
    """Put a position into the delay line and return the one that comes out of it [m].

    Parameters
    ----------
    line : ndarray, shape (samples of delay,)
        From :func:`delay_line`; written.
    sample : int
        Number of the sample, one more than in the call before.
    position : float
        True position at that sample [m].
    """
    if line.size == 0:
        return position
    place = sample % line.size
    before = float(line[place])
    line[place] = position
    return before


def recent_positions() -> FloatArray:
    """Return what came out of a delay line before the first sample: the platform at rest at zero.

    Returns
    -------
    ndarray, shape (3,)
        Positions [m], the newest first; see :func:`between_samples`.
    """
    return np.zeros(3)


def between_samples(position: float, recent: FloatArray, weights: Weights) -> float:
    """Return the position that a part of a sample makes of those that came out of a line [m].

    Parameters
    ----------
    position : float
        The newest one [m].
    recent : ndarray, shape (3,)
        From :func:`recent_positions`; written.
    weights : tuple of float
        From :func:`discretize_delay`.
    """
    w0, w1, w2, w3 = weights
    p1, p2, p3 = float(recent[0]), float(recent[1]), float(recent[2])
    recent[0], recent[1], recent[2] = position, p1, p2
    return w0 * position + w1 * p1 + w2 * p2 + w3 * p3
