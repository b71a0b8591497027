"""A bag as the stream that a loop would be: what it holds, at a pace, with pauses."""

import math

import numpy as np
from numpy.typing import NDArray

from bdt_bags.run_signals import RunSignals
from bdt_live.extremes import RowMaker

FloatArray = NDArray[np.float64]

STEP = 0.04
"""Time of a single step [s]."""


class Playback:
    """Plays a run.

    Parameters
    ----------
    run : RunSignals
        From a bag.

    Attributes
    ----------
    time : float
        Time of the run up to which it was played [s].
    pace : float
        Seconds of the run in a second of wall time.
    is_paused : bool
        Whether it waits for a user; so it does at the end.
    """

    def __init__(self, run: RunSignals) -> None:
        self._run = run
        self._rows = RowMaker()
        self.pace, self.is_paused = 1.0, False
        self.rewind()

    def rewind(self) -> None:
        """Begin at the beginning."""
        self._rows.restart()
        self.time = float(self._run.telemetry[0, 0])
        self._played = self._truth_played = 0

    @property
    def is_over(self) -> bool:
        """Whether all was played."""
        return self._played >= len(self._run.telemetry)

    def advance(self, elapsed: float) -> list[list[float | None]]:
        """Return the rows of what comes in some wall time [s]."""
        return [] if self.is_paused else self._play(elapsed * self.pace)

    def step(self) -> list[list[float | None]]:
        """Return the rows of one step."""
        return self._play(STEP)

    def _play(self, duration: float) -> list[list[float | None]]:
        self.time += duration
        telemetry, truth = self._run.telemetry, self._run.truth
        stop = int(np.searchsorted(telemetry[:, 0], self.time, side="right"))
        if stop > self._played:
            self._rows.take_telemetry(telemetry[self._played : stop])
            self._played = stop
        if truth is not None:
            known = int(np.searchsorted(truth[:, 0], self.time, side="right"))
            if known > self._truth_played:
                self._rows.take_truth(truth[self._truth_played : known])
                self._truth_played = known
        self._rows.held = {
            "reference": _held(self._run.reference, self.time),
            "dead_zone": _held(self._run.dead_zones, self.time),
            "estimate": _held(self._run.estimates, self.time),
            "uncertainty": _held(self._run.uncertainties, self.time),
        }
        if self.is_over:
            self.time, self.is_paused = float(telemetry[-1, 0]), True
        return self._rows.rows()


def _held(rows: FloatArray, time: float) -> float | None:
    """Return what holds at a time, of rows of (time from which it holds, value)."""
    row = int(np.searchsorted(rows[:, 0], time, side="right")) - 1
    value = float(rows[row, 1]) if row >= 0 else math.nan
    return value if math.isfinite(value) else None
