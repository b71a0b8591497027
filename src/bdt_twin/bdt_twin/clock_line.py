"""The even clock behind stamps with jitter: a straight line through stamps over sample numbers."""

import math

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import float_exponential
from bdt_twin.fixed_order import dot, mean, total

FloatArray = NDArray[np.float64]

MEMORY = 10.0
"""Time in which old stamps lose their weight [s]."""
LOST = 0.5
"""Sample times by which a whole batch is off where samples were lost: the line begins anew."""


class ClockLine:
    """Fits a line to stamps, of which the newest count most.

    Parameters
    ----------
    sampling_rate : float
        Nominal sampling rate [Hz].

    Attributes
    ----------
    jitter : float
        Standard deviation of the newest stamps from the line [s].
    rate : float
        Samples in a second, by the line [Hz].
    """

    def __init__(self, sampling_rate: float) -> None:
        self._step = 1.0 / sampling_rate
        self.jitter, self.rate = 0.0, sampling_rate
        self._clear()

    def _clear(self) -> None:
        # Sums over the stamps: of weights, times the number, squared; of how late they are.
        self._weight = self._number = self._square = self._late = self._product = 0.0
        self._reference = math.nan

    def times(self, stamps: FloatArray) -> FloatArray:
        """Take the stamps [s] of the next samples, shape (n,), and return their times by the line.

        Numbers are counted from the newest sample back, and lateness is that against the nominal
        clock through the newest sample before.
        """
        count = stamps.size
        if math.isnan(self._reference):
            self._reference = float(stamps[0]) - self._step
        numbers = np.arange(1.0 - count, 1.0)
        late = stamps - (self._reference + self._step * (numbers + count))
        if self._weight > 0.0:
            # The line as it was, seen from the newest sample.
            offset, slope = self._line()
            expected = offset + slope * (numbers + count)
            if abs(mean(late - expected)) > LOST * self._step:
                self._clear()
                return self.times(stamps)
        forgotten = float_exponential(-count * self._step / MEMORY)
        weight, number, square = self._weight, self._number, self._square
        self._weight = forgotten * weight + count
        self._number = forgotten * (number - count * weight) + total(numbers)
        self._square = forgotten * (square - 2.0 * count * number + count * count * weight)
        self._square += dot(numbers, numbers)
        self._product = forgotten * (self._product - count * self._late) + dot(numbers, late)
        self._late = forgotten * self._late + total(late)
        offset, slope = self._line()
        line = offset + slope * numbers
        self.jitter = math.sqrt(mean(np.square(late - line)))
        self.rate = 1.0 / (self._step + slope)
        times: FloatArray = stamps - (late - line)
        # The next lateness is against the clock that has gone on.
        self._reference += self._step * count
        return times

    def _line(self) -> tuple[float, float]:
        """Return lateness at the newest sample [s] and its growth per sample [s]."""
        spread = self._weight * self._square - self._number * self._number
        if spread <= 0.0:
            return self._late / self._weight, 0.0
        slope = (self._weight * self._product - self._number * self._late) / spread
        return (self._late - slope * self._number) / self._weight, slope
