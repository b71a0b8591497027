"""Times of samples that the hardware's own clock has made, on the clock of this computer.

The two clocks run at rates that differ by a thousandth perhaps, and a reading arrives when a
transport and an operating system let it: neither may show in the times. A phase-locked loop of
second order follows the arrivals slowly, so that samples stay even to well within the hundredth
that the twin asks for, and on average at the true rate.
"""

import numpy as np
from numpy.typing import NDArray

FOLLOWED = 0.01
"""Share of an arrival's deviation by which the times move at once."""
LARGEST_SHIFT = 0.004
"""Largest relative change of the distance of two samples because of that."""
LARGEST_DRIFT = 0.005
"""Largest relative difference of the two clocks that is followed."""
LOST_TRACK = 0.25
"""Deviation [s] of an arrival beyond which the times begin anew."""


class HardwareClock:
    """Gives each sample its time.

    Parameters
    ----------
    rate : float
        Sampling rate as the hardware states it [Hz].

    Attributes
    ----------
    restarts : int
        How often the times began anew because arrivals were elsewhere.
    """

    def __init__(self, rate: float) -> None:
        self._nominal = 1.0 / rate
        self._sample_time = self._nominal
        self._newest: float | None = None
        self.restarts = 0

    @property
    def drift(self) -> float:
        """Relative difference of the sample time to the stated one, as found."""
        return self._sample_time / self._nominal - 1.0

    def times(self, count: int, lost: int, arrival: float) -> NDArray[np.float64]:
        """Return the times of the samples that have arrived.

        Parameters
        ----------
        count : int
            Their number, one at least.
        lost : int
            Number of samples that were lost before them.
        arrival : float
            Time at which the newest one arrived [s].

        Returns
        -------
        ndarray, shape (count,)
            Times [s], even, in continuation of the samples before.
        """
        passed = count + lost
        predicted = arrival
        if self._newest is not None:
            predicted = self._newest + passed * self._sample_time
        deviation = arrival - predicted
        if abs(deviation) > LOST_TRACK:
            self.restarts += 1
            self._newest, deviation = arrival, 0.0
            self._sample_time = self._nominal
            return _even(arrival, self._sample_time, count)
        reach = LARGEST_SHIFT * passed * self._sample_time
        newest = predicted + min(max(FOLLOWED * deviation, -reach), reach)
        begin = newest - passed * self._sample_time if self._newest is None else self._newest
        self._newest = newest
        step = (newest - begin) / passed
        change = 0.25 * FOLLOWED**2 * deviation / passed
        largest = LARGEST_DRIFT * self._nominal
        self._sample_time = min(
            max(self._sample_time + change, self._nominal - largest), self._nominal + largest
        )
        return _even(newest, step, count)


def _even(newest: float, step: float, count: int) -> NDArray[np.float64]:
    times: NDArray[np.float64] = newest + step * np.arange(1 - count, 1, dtype=np.float64)
    return times
