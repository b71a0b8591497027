"""The gap at the samples of a stretch of data: straight lines between the knots of a window."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bdt_twin.stretch import Stretch

FloatArray = NDArray[np.float64]


class GapSamples:
    """Where the samples of a stretch are between the knots.

    Parameters
    ----------
    knots : ndarray, shape (knots,)
        Times of the gap's knots, evenly spaced [s].
    stretch : Stretch
        The data.
    sampling_rate : float
        Sampling rate [Hz].
    """

    def __init__(self, knots: FloatArray, stretch: Stretch, sampling_rate: float) -> None:
        times = (stretch.first + np.arange(stretch.voltage.size)) / sampling_rate
        places = (times - knots[0]) / (knots[1] - knots[0])
        before = np.clip(places.astype(np.int64), 0, knots.size - 2)
        self._shares = np.clip(places - before, 0.0, 1.0)
        ends = np.searchsorted(before, np.arange(knots.size)).tolist()
        self._spans = [slice(begin, end) for begin, end in pairwise(ends)]

    def at(self, gaps: FloatArray) -> FloatArray:
        """Return the gap at each sample [rad], shape (n,), for gaps at the knots."""
        found, changes = np.empty(self._shares.size), np.diff(gaps)
        # From knot to knot, which takes a third of the time of looking up each sample's.
        for knot, span in enumerate(self._spans):
            np.multiply(self._shares[span], changes[knot], out=found[span])
            found[span] += gaps[knot]
        return found


def knot_weights(knots: FloatArray, times: FloatArray) -> FloatArray:
    """Return by how much the gap at each time depends on that at each knot, shape (knots, n).

    Parameters
    ----------
    knots : ndarray, shape (knots,)
        Times of the gap's knots, evenly spaced [s].
    times : ndarray, shape (n,)
        The times, none before the first knot or after the last one [s].
    """
    distance = np.abs(times[None, :] - knots[:, None]) / (knots[1] - knots[0])
    weights: FloatArray = np.maximum(1.0 - distance, 0.0)
    return weights
