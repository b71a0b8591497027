"""Continuity of the telemetry: what an estimator with memory may be given."""

import numpy as np
from numpy.typing import NDArray

from bdt_twin.estimator import TelemetryRejectedError

TIME_TOLERANCE = 0.01
"""Largest deviation of a time step, as a fraction of the sample time."""


class TelemetryStream:
    """Checks that batches continue each other without holes.

    A batch that is rejected ends the stream. The next one begins a new stream, so whoever uses
    the data must start anew.

    Parameters
    ----------
    sampling_rate : float
        Sampling rate [Hz].
    """

    def __init__(self, sampling_rate: float) -> None:
        self._sample_time = 1.0 / sampling_rate
        self._last_time: float | None = None

    def accept(self, rows: NDArray[np.float64]) -> bool:
        """Take the next batch.

        Parameters
        ----------
        rows : ndarray, shape (n, 3)
            Telemetry rows (t [s], u [V], q3 [m]).

        Returns
        -------
        bool
            True when the batch begins a stream, the first one included.

        Raises
        ------
        TelemetryRejectedError
            For an empty batch, a value that is not finite, a hole, or time that goes back.
        """
        reason = self._fault(rows)
        if reason:
            self._last_time = None
            raise TelemetryRejectedError(reason)
        begins = self._last_time is None
        self._last_time = float(rows[-1, 0])
        return begins

    def _fault(self, rows: NDArray[np.float64]) -> str | None:
        if not len(rows):
            return "the batch is empty"
        if not np.isfinite(rows).all():
            return f"row {np.flatnonzero(~np.isfinite(rows).all(axis=1))[0]} is not finite"
        before = [] if self._last_time is None else [self._last_time]
        steps = np.diff(np.concatenate([before, rows[:, 0]]))
        tolerance = step_tolerance(rows[:, 0], self._sample_time)
        wrong = np.flatnonzero(np.abs(steps - self._sample_time) > tolerance)
        if not wrong.size:
            return None
        step = float(steps[wrong[0]])
        where = f"at t = {rows[wrong[0] + 1 - len(before), 0]:.6f} s"
        if step <= 0:
            return f"time goes back by {abs(step):.6f} s {where}"
        return f"time step of {step:.6f} s instead of {self._sample_time:.6f} s {where}"


def step_tolerance(times: NDArray[np.float64], sample_time: float) -> float:
    """Return by how much a time step may differ from the sample time and is even [s].

    Parameters
    ----------
    times : ndarray, shape (n,)
        Stamps [s], n at least 1: epoch seconds in a float64 resolve a quarter of a microsecond.
    sample_time : float
        Sample time [s].
    """
    return TIME_TOLERANCE * sample_time + 4 * float(np.spacing(np.abs(times).max()))
