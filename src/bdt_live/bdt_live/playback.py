"""A bag as the stream that a loop would be: what it holds, at a pace, with pauses."""

import numpy as np

from bdt_bags.run_signals import RunSignals
from bdt_live.extremes import RowMaker

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
        self.pace, self.is_paused = 1.0, False
        self.rewind()

    def rewind(self) -> None:
        """Begin at the beginning."""
        self._rows = RowMaker()
        for name, rows in (
            ("reference", self._run.reference),
            ("dead_zone", self._run.dead_zones),
            ("estimate", self._run.estimates),
            ("uncertainty", self._run.uncertainties),
        ):
            for time, value in rows.tolist():
                self._rows.hold(name, time, value)
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
        if self.is_over:
            self.time, self.is_paused = float(telemetry[-1, 0]), True
        return self._rows.rows()
