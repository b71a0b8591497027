"""Telemetry without a hole."""

from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

LEAD = 0.01
"""Time before a stretch whose voltage tells how fast the motor is at its beginning [s]."""


class Stretch(NamedTuple):
    """Telemetry without a hole.

    Attributes
    ----------
    first : int
        Number of the first sample: its time times the sampling rate.
    voltage, position : ndarray, shape (n,)
        Motor voltage u [V] and position q3 [m]; n is a multiple of the samples in a block.
    before : ndarray, shape (m,)
        Motor voltage of the samples before the first one [V], as far as it is known.
    """

    first: int
    voltage: FloatArray
    position: FloatArray
    before: FloatArray = np.empty(0)

    def coarse(self, every: int, block: int) -> "Stretch":
        """Return the stretch with one position of several, and the means of the voltages between.

        Parameters
        ----------
        every : int
            Samples of which one is kept: those whose numbers are multiples.
        block : int
            Samples in a block of what is returned.
        """
        skipped = -self.first % every
        count = (self.voltage.size - skipped) // every // block * block
        kept = slice(skipped, skipped + count * every)
        before = np.concatenate([self.before, self.voltage[:skipped]])
        before = before[before.size % every :]
        return Stretch(
            (self.first + skipped) // every,
            _means(self.voltage[kept], every),
            self.position[kept][::every],
            _means(before, every),
        )


def _means(values: FloatArray, every: int) -> FloatArray:
    """Return the means of several values each."""
    means: FloatArray = reduce(np.add, values.reshape(-1, every).T) / every
    return means
