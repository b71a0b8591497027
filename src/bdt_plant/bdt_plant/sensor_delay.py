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
    is_whole : bool
        Whether that is all.
    weights : tuple of float
        What the positions `samples`, ... `samples` + 3 samples ago count.
    """

    samples: int
    is_whole: bool
    weights: Weights


def discretize_delay(delay: float, sampling_rate: float) -> DiscreteDelay:
    """Return a delay [s] for samples at `sampling_rate` [Hz]."""
    age = delay * sampling_rate
    if abs(age - round(age)) <= ROUNDING * max(age, 1.0):
        return DiscreteDelay(round(age), True, (1.0, 0.0, 0.0, 0.0))
    samples = int(age)
    x = age - samples
    # The cubics that are one at one of the ages 0, 1, 2, 3 and zero at the others.
    weights = (
        (x - 1.0) * (x - 2.0) * (x - 3.0) / -6.0,
        x * (x - 2.0) * (x - 3.0) / 2.0,
        x * (x - 1.0) * (x - 3.0) / -2.0,
        x * (x - 1.0) * (x - 2.0) / 6.0,
    )
    return DiscreteDelay(samples, False, weights)


def delay_line(delay: DiscreteDelay) -> FloatArray:
    """Return what a sensor remembers before its first sample: the platform at rest at zero.

    Returns
    -------
    ndarray, shape (samples of delay,), and 4 more when these are not whole
        Positions [m]; see :func:`delayed`.
    """
    return np.zeros(delay.samples if delay.is_whole else delay.samples + 4)


def delayed(line: FloatArray, sample: int, position: float, delay: DiscreteDelay) -> float:
    """Put a position into the delay line and return the one that the sensor sees [m].

    Parameters
    ----------
    line : ndarray
        From :func:`delay_line`; written.
    sample : int
        Number of the sample, one more than in the call before.
    position : float
        True position at that sample [m].
    delay : DiscreteDelay
        From :func:`discretize_delay`.
    """
    if line.size == 0:
        return position
    place = sample % line.size
    if delay.is_whole:
        before = float(line[place])
        line[place] = position
        return before
    line[place] = position
    newest, size = sample - delay.samples + line.size, line.size
    w0, w1, w2, w3 = delay.weights
    return (
        w0 * float(line[newest % size])
        + w1 * float(line[(newest - 1) % size])
        + w2 * float(line[(newest - 2) % size])
        + w3 * float(line[(newest - 3) % size])
    )
