"""Readings in a row, and what can be told from them."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bdt_driver.drive import Reading

FloatArray = NDArray[np.float64]


@dataclass
class Record:
    """Readings in the order in which they were made.

    Attributes
    ----------
    began, ended : list of float
        When each call began and returned [s].
    readings : list of Reading
        What was read.
    """

    began: list[float] = field(default_factory=list)
    ended: list[float] = field(default_factory=list)
    readings: list[Reading] = field(default_factory=list)

    def __add__(self, other: "Record") -> "Record":
        return Record(
            self.began + other.began, self.ended + other.ended, self.readings + other.readings
        )

    @property
    def positions(self) -> FloatArray:
        """Position of each reading [m], shape (n,)."""
        return np.array([reading.position for reading in self.readings])

    @property
    def voltages(self) -> FloatArray:
        """Voltage that each reading tells [V], shape (n,)."""
        return np.array([reading.voltage for reading in self.readings])

    @property
    def call_times(self) -> FloatArray:
        """How long each call lasted [s], shape (n,)."""
        times: FloatArray = np.array(self.ended) - np.array(self.began)
        return times

    @property
    def passed_samples(self) -> FloatArray:
        """Number of samples, lost ones included, up to each reading, shape (n,)."""
        counts = [
            (0 if reading.samples is None else len(reading.samples)) + reading.lost
            for reading in self.readings
        ]
        return np.array(np.cumsum(counts), dtype=np.float64)

    @property
    def lost_samples(self) -> int:
        """Number of samples that the drive tells are lost."""
        return sum(reading.lost for reading in self.readings)

    @property
    def change(self) -> float:
        """How far the platform is from where it was at the first reading [m]."""
        return self.readings[-1].position - self.readings[0].position

    def noise(self) -> float:
        """Return the standard deviation of the positions [m], blind to drift and single spikes."""
        differences = np.diff(self.positions)
        spread = float(np.median(np.abs(differences - np.median(differences))))
        # The median deviation of a normal variable is 0.674 of its standard deviation.
        return spread / 0.6745 / math.sqrt(2.0)

    def largest_told(self) -> float:
        """Return the voltage of the largest size that was told [V], with its sign."""
        return float(self.voltages[np.argmax(np.abs(self.voltages))])

    def time_until_told(self, voltage: float) -> float:
        """Return how long after the first reading a voltage [V] was told to within half of it.

        Infinite if it never was.
        """
        is_told = np.abs(self.voltages - voltage) <= 0.5 * abs(voltage)
        return self._time_of_first(is_told)

    def time_until_zero(self, voltage: float) -> float:
        """Return how long after the first reading less than a hundredth of a voltage was told [s].

        Infinite if it never was.
        """
        return self._time_of_first(np.abs(self.voltages) <= 0.01 * abs(voltage))

    def _time_of_first(self, holds: NDArray[np.bool_]) -> float:
        if not holds.any():
            return math.inf
        return self.ended[int(np.argmax(holds))] - self.began[0]
