"""What telemetry tells of the loop without its reference: rests, steps, and whether it rests.

Rest is a second in which the platform moves less than in a limit cycle. Noise is not motion:
looked at are the middles of what is read in 20 ms.
"""

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

BLOCK = 0.02
"""Time over which readings are put together [s]."""
REST = 1.0
"""Time with little motion that is rest [s]: longer than the period of a limit cycle, 0.7 s."""
REMEMBERED = 4
"""Newest steps that are remembered."""
NUDGE = 0.1
"""Share of the largest step below which a motion is none."""
LIMIT_CYCLE = 3.0
"""Peak to peak over the lost motion p theta_b that is less than any limit cycle's: it is 6."""
HARMLESS = 0.01
"""Peak to peak over the height of a step up to which a limit cycle is none for the report."""


class LoopWatch:
    """Watches the loop come to rest and leave it.

    Parameters
    ----------
    patience : float
        Time without rest [s], beyond what was expected, that is worse than expected.
    height : float
        Height of steps [m] as long as none was seen.

    Attributes
    ----------
    heights : deque of float
        Heights of the newest steps [m], the oldest first.
    """

    def __init__(self, patience: float, height: float) -> None:
        self._patience, self._height = patience, height
        self._allowed, self._lost_motion = math.inf, 0.0
        self._middles: deque[float] = deque(maxlen=round(REST / BLOCK))
        self._block: int | None = None
        self._lowest = self._highest = 0.0
        self._rested = self._begun = self._level = math.nan
        self._is_at_rest, self._resting_at = False, 0.0
        self.heights: deque[float] = deque(maxlen=REMEMBERED)
        self._lengths: deque[float] = deque(maxlen=REMEMBERED)

    @property
    def step_time(self) -> float | None:
        """Time from one step to the next [s]; None as long as there were no two."""
        return max(self._lengths, default=None)

    def expect(self, longest: float, lost_motion: float) -> None:
        """Expect rest within a time after whatever moves the loop.

        Parameters
        ----------
        longest : float
            That time [s]; infinite for no expectation.
        lost_motion : float
            Lost motion of the gap, p theta_b [m].
        """
        self._allowed, self._lost_motion = longest + REST, lost_motion

    def take(self, rows: FloatArray) -> str:
        """Take telemetry, and return what is worse than expected; empty for nothing.

        Parameters
        ----------
        rows : ndarray, shape (n, 3)
            Telemetry rows (t [s], u [V], q3 [m]), oldest first.
        """
        # Half a block off, so that no stamp lies on an edge.
        numbers = np.floor(rows[:, 0] / BLOCK + 0.5).astype(np.int64)
        begins = np.flatnonzero(np.diff(numbers, prepend=numbers[0] - 1))
        lowest = np.minimum.reduceat(rows[:, 2], begins).tolist()
        highest = np.maximum.reduceat(rows[:, 2], begins).tolist()
        text = ""
        for block, low, high in zip(numbers[begins].tolist(), lowest, highest, strict=True):
            if block == self._block:
                self._lowest, self._highest = min(self._lowest, low), max(self._highest, high)
                continue
            text = self._end_block() or text
            self._block, self._lowest, self._highest = block, low, high
        return text

    def _end_block(self) -> str:
        """Judge the block that is complete; return what is worse than expected."""
        if self._block is None:
            return ""
        now = self._block * BLOCK
        if math.isnan(self._rested):
            self._rested = now
        self._middles.append(0.5 * (self._lowest + self._highest))
        swing = max(self._middles) - min(self._middles)
        largest = max(self.heights, default=self._height)
        calm = max(LIMIT_CYCLE * self._lost_motion, HARMLESS * largest)
        if len(self._middles) == self._middles.maxlen and swing <= calm:
            self._rested, self._is_at_rest = now, True
            self._resting_at = self._middles[0]
        elif self._is_at_rest:
            self._is_at_rest = False
            self._leave_rest(now, self._resting_at)
        restless = now - self._rested
        if restless <= self._allowed + self._patience:
            return ""
        self._rested = now
        return f"the loop has not rested for {restless:.3g} s, {self._allowed:.3g} s were expected"

    def _leave_rest(self, time: float, level: float) -> None:
        height = abs(level - self._level)
        if not math.isnan(self._level) and height >= NUDGE * max(self.heights, default=0.0):
            self.heights.append(height)
            self._lengths.append(time - self._begun)
        self._begun, self._level = time, level
