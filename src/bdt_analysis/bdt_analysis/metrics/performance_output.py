"""The position by which a loop is judged: the true one where it is known."""

import numpy as np
from numpy.typing import NDArray

from bdt_bags.run_signals import RunSignals

FloatArray = NDArray[np.float64]

_POSITION_COLUMN = 6


def performance_output(run: RunSignals) -> tuple[FloatArray, float]:
    """Return the samples by which a loop is judged, and their sample time [s].

    A simulator knows the true position, so noise of its sensor need not count as a residual of
    the loop. Telemetry that holds the true position is taken as it is, because it has more
    samples, and so is telemetry without a truth that spans it.

    Parameters
    ----------
    run : RunSignals
        A run, recorded or simulated.

    Returns
    -------
    rows : ndarray, shape (n, 3)
        Rows of (t [s], u [V], q3 [m]): the telemetry, or the truth at its own rate.
    sample_time : float
        Sample time of the rows [s].
    """
    measured = run.telemetry, run.sample_time
    if run.truth is None or not _spans(run.truth[:, 0], run.telemetry[:, 0]):
        return measured
    times, position = run.truth[:, 0], run.truth[:, _POSITION_COLUMN]
    same = np.searchsorted(run.telemetry[:, 0], times).clip(max=len(run.telemetry) - 1)
    rows = run.telemetry[same]
    if (rows[:, 0] != times).any() or (rows[:, 2] == position).all():
        return measured
    rows[:, 2] = position
    return rows, float(np.median(np.diff(times)))


def _spans(inner: FloatArray, outer: FloatArray) -> bool:
    """Tell whether times without a hole reach from end to end of others."""
    if inner.size < 2:
        return False
    steps = np.diff(inner)
    longest = 1.5 * float(np.median(steps))
    ends = (abs(inner[0] - outer[0]), abs(outer[-1] - inner[-1]), steps.max())
    return bool(max(ends) < longest)
