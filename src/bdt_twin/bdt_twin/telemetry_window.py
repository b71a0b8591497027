"""The newest telemetry as stretches without holes, cut the same however it arrived."""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_twin.estimator import TelemetryRejectedError
from bdt_twin.stretch import LEAD, Stretch
from bdt_twin.telemetry_stream import step_tolerance


class _Batch(NamedTuple):
    first: int
    rows: NDArray[np.float64]

    @property
    def end(self) -> int:
        """Number of the sample after the last one."""
        return self.first + len(self.rows)


class TelemetryWindow:
    """Keeps the newest samples and numbers them.

    A sample's number is its time times the sampling rate, rounded at the beginning of each
    stretch and counted from there on.

    Parameters
    ----------
    sampling_rate : float
        Sampling rate [Hz].
    length : int
        Samples to keep.
    """

    def __init__(self, sampling_rate: float, length: int) -> None:
        self._rate, self._length = sampling_rate, length
        self._lead = round(LEAD * sampling_rate)
        self.restart()

    def restart(self) -> None:
        """Forget all samples."""
        self._batches: deque[_Batch] = deque()

    @property
    def end(self) -> int | None:
        """Number of the sample after the newest one; None without any."""
        return self._batches[-1].end if self._batches else None

    def append(self, rows: NDArray[np.float64]) -> range:
        """Take the next batch.

        Parameters
        ----------
        rows : ndarray, shape (n, 3)
            Telemetry rows (t [s], u [V], q3 [m]).

        Returns
        -------
        range
            Numbers of its samples.

        Raises
        ------
        TelemetryRejectedError
            For an empty batch, a value that is not finite, a time step within the batch other
            than the sample time, or a batch that begins before the last one ended. The last
            one makes the window forget what it holds; the others leave it with a hole.
        """
        if not len(rows):
            raise TelemetryRejectedError("the batch is empty")
        wrong = np.flatnonzero(~np.isfinite(rows).all(axis=1))
        if wrong.size:
            raise TelemetryRejectedError(f"row {wrong[0]} is not finite")
        tolerance = step_tolerance(rows[:, 0], 1.0 / self._rate)
        first = self._number(float(rows[0, 0]), tolerance)
        steps = np.diff(rows[:, 0])
        wrong = np.flatnonzero(np.abs(steps - 1.0 / self._rate) > tolerance)
        if wrong.size:
            raise TelemetryRejectedError(
                f"time step of {steps[wrong[0]]:.6f} s instead of {1.0 / self._rate:.6f} s "
                f"at t = {rows[wrong[0] + 1, 0]:.6f} s"
            )
        self._batches.append(_Batch(first, np.array(rows)))
        return range(first, first + len(rows))

    def forget(self, end: int) -> None:
        """Forget what no window that ends at sample number `end` or later holds."""
        while self._batches and self._batches[0].end <= end - self._length - self._lead:
            self._batches.popleft()

    def time(self, number: int) -> float:
        """Return the time of a sample that is in the window [s]."""
        batch = next(batch for batch in self._batches if batch.first <= number < batch.end)
        return float(batch.rows[number - batch.first, 0])

    def stretches(self, end: int, shortest: int, block: int) -> list[Stretch]:
        """Return the stretches of the window before sample number `end`, oldest first.

        Parameters
        ----------
        end : int
            Number of the sample after the window.
        shortest : int
            Samples that a stretch must have.
        block : int
            Number of which each stretch's samples are made a multiple, at the old end.
        """
        runs: list[list[_Batch]] = []
        for batch in self._batches:
            if not runs or runs[-1][-1].end != batch.first:
                runs.append([])
            runs[-1].append(batch)
        found = []
        for run in runs:
            rows = np.concatenate([batch.rows for batch in run])
            begins = run[0].first
            last = min(end, begins + len(rows))
            first = max(end - self._length, begins)
            count = (last - first) // block * block
            if count >= max(shortest, block):
                begin = last - count - begins
                kept = rows[begin : last - begins]
                u, q3 = np.ascontiguousarray(kept[:, 1]), np.ascontiguousarray(kept[:, 2])
                before = rows[max(begin - self._lead, 0) : begin, 1].copy()
                found.append(Stretch(last - count, u, q3, before))
        return found

    def _number(self, time: float, tolerance: float) -> int:
        if not self._batches:
            return round(time * self._rate)
        newest = self._batches[-1]
        step = time - float(newest.rows[-1, 0])
        if step <= 0:
            self.restart()
            raise TelemetryRejectedError(f"time goes back by {abs(step):.6f} s at t = {time:.6f} s")
        if abs(step - 1.0 / self._rate) <= tolerance:
            return newest.end
        # One number is left out at least, so that the hole shows.
        return max(round(time * self._rate), newest.end + 1)
