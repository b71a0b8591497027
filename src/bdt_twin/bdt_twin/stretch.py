"""Telemetry without a hole."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_twin.fixed_order import block_means

FloatArray = NDArray[np.float64]

LEAD = 0.01
"""Time before a stretch whose voltage tells how fast the motor is at its beginning [s]."""


class Stretch(NamedTuple):
    """Telemetry without a hole.

    Attributes
    ----------
    first : float
        Number of the first sample: its time times the sampling rate. That of a mean is the middle
        of its samples, which need not be whole.
    voltage, position : ndarray, shape (n,)
        Motor voltage u [V] and position q3 [m]; n is a multiple of the samples in a block.
    before : ndarray, shape (m,)
        Motor voltage of the samples before the first one [V], as far as it is known.
    readings : ndarray, shape (k n,), or None
        What the sensor read where the positions are means of k readings each [m]; None where they
        are the readings.
    """

    first: float
    voltage: FloatArray
    position: FloatArray
    before: FloatArray = np.empty(0)
    readings: FloatArray | None = None

    def newest(self, count: int, lead: int) -> "Stretch":
        """Return the stretch of the newest samples.

        Parameters
        ----------
        count : int
            Most samples of it.
        lead : int
            Most samples before it.
        """
        left = max(self.voltage.size - count, 0)
        each = 0 if self.readings is None else self.readings.size // self.position.size
        return Stretch(
            self.first + left,
            self.voltage[left:],
            self.position[left:],
            np.append(self.before, self.voltage[:left])[-lead:],
            None if self.readings is None else self.readings[each * left :],
        )

    def averaged(self, every: int, block: int) -> "Stretch":
        """Return the means of several samples each.

        A mean position is that in the middle of its samples, and the voltage is the mean over the
        time from there to the next one's, so the motor turns as far. The middles are where most
        changes of the voltage are, which leaves it constant in between. What is before the first
        mean and after the last whole block is left out.

        Parameters
        ----------
        every : int
            Samples of which a mean is taken.
        block : int
            Means in a block.
        """
        changes = np.flatnonzero(np.diff(self.voltage)) + 1 - (every - 1) // 2
        skipped = int(np.bincount(changes % every, minlength=every).argmax())
        count = (self.voltage.size - skipped) // (every * block) * block
        kept = slice(skipped, skipped + count * every)
        held = np.concatenate([self.before, self.voltage, np.repeat(self.voltage[-1:], every)])
        if every % 2 == 0:
            # From the middle between two samples to that of the next two.
            held = 0.5 * (held[:-1] + held[1:])
        begin = self.before.size + skipped + (every - 1) // 2
        lead = begin // every
        means = block_means(held[begin % every :][: (lead + count) * every], every)
        measured = self.position if self.readings is None else self.readings
        each = measured.size // self.position.size
        return Stretch(
            (self.first + skipped + 0.5 * (every - 1)) / every,
            means[lead:],
            block_means(self.position[kept], every),
            means[:lead],
            measured[each * kept.start : each * kept.stop],
        )
