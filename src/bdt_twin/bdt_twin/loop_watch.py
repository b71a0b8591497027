"""What telemetry tells of the loop without its reference: rests, steps, and whether it rests.

In the dead zone the voltage does not change, and outside it always does.
"""

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

REST = 1.0
"""Time without a change of the voltage that is rest [s]: several times the longest pause in a limit
cycle, whose period is 0.7 s."""
REMEMBERED = 4
"""Newest steps that are remembered."""
NUDGE = 0.1
"""Share of the largest step below which a motion is none."""


class LoopWatch:
    """Watches the loop come to rest and leave it.

    Parameters
    ----------
    patience : float
        Time without rest [s], beyond what was expected, that is worse than expected.

    Attributes
    ----------
    heights : deque of float
        Heights of the newest steps [m], the oldest first.
    """

    def __init__(self, patience: float) -> None:
        self._patience = patience
        self._allowed = math.inf
        self._rested = self._changed = self._voltage = math.nan
        self._begun = self._level = math.nan
        self.heights: deque[float] = deque(maxlen=REMEMBERED)
        self._lengths: deque[float] = deque(maxlen=REMEMBERED)

    @property
    def step_time(self) -> float | None:
        """Time from one step to the next [s]; None as long as there were no two."""
        return max(self._lengths, default=None)

    def expect(self, longest: float) -> None:
        """Expect that the loop comes to rest within a time [s] after whatever moves it."""
        self._allowed = longest + REST

    def take(self, rows: FloatArray) -> str:
        """Take telemetry, and return what is worse than expected; empty for nothing.

        Parameters
        ----------
        rows : ndarray, shape (n, 3)
            Telemetry rows (t [s], u [V], q3 [m]), oldest first.
        """
        time, voltage = rows[:, 0], rows[:, 1]
        if math.isnan(self._rested):
            self._rested = self._changed = float(time[0])
        before = np.concatenate([[self._voltage], voltage[:-1]])
        places = np.flatnonzero(voltage != before)
        moments = np.concatenate([[self._changed], time[places]])
        for rest in np.flatnonzero(np.diff(moments) >= REST).tolist():
            # The sample at which the voltage changes is the last one at the old level.
            self._leave_rest(float(moments[rest + 1]), float(rows[places[rest], 2]))
        self._changed, self._voltage = float(moments[-1]), float(voltage[-1])
        now = float(time[-1])
        if now - self._changed >= REST:
            self._rested = now
        restless = now - self._rested
        if restless <= self._allowed + self._patience:
            return ""
        self._rested = now
        return f"the loop has not rested for {restless:.3g} s, {self._allowed:.3g} s were expected"

    def _leave_rest(self, time: float, level: float) -> None:
        self._rested = time
        height = abs(level - self._level)
        if not math.isnan(self._level) and height >= NUDGE * max(self.heights, default=0.0):
            self.heights.append(height)
            self._lengths.append(time - self._begun)
        self._begun, self._level = time, level
