"""Fewer points for pictures, without losing an extreme."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SHORTEST_HOLE = 0.02
"""Time [s] without samples up to which a line goes on: a sensor that drops single samples would
otherwise cut it into as many pieces."""


def envelope(
    time: FloatArray, value: FloatArray, columns: int, longest_interval: float = np.inf
) -> tuple[FloatArray, FloatArray]:
    """Return the smallest and the largest sample of each pixel column, in their order.

    A line through the result covers the same pixels as one through all samples.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Times in increasing order.
    value : ndarray, shape (n,)
        Samples.
    columns : int
        Number of pixel columns over the whole time.
    longest_interval : float
        Time between two samples above which the line is interrupted; same unit as `time`.

    Returns
    -------
    time, value : ndarray, shape (k,)
        At most four points a column and a NaN for each interruption; everything when that is not
        less.
    """
    kept: list[NDArray[np.intp]] = []
    breaks = np.flatnonzero(np.diff(time) > longest_interval) + 1
    if time.size <= 4 * columns:
        kept = [np.asarray(part) for part in np.split(np.arange(time.size), breaks)]
    else:
        span = (time[-1] - time[0]) or 1.0
        column = ((time - time[0]) * (columns / span)).astype(np.intp)
        starts = np.flatnonzero(np.diff(column, prepend=-1))
        for first, end in zip(*_segments(starts, breaks, time.size), strict=True):
            part = value[first:end]
            chosen = {first, first + int(part.argmin()), first + int(part.argmax()), end - 1}
            kept.append(np.array(sorted(chosen)))
    times, values = [], []
    interrupted = set(breaks.tolist())
    for indices in kept:
        if indices.size and int(indices[0]) in interrupted:
            times.append(time[indices[:1]])
            values.append(np.array([np.nan]))
        times.append(time[indices])
        values.append(value[indices])
    return np.concatenate(times), np.concatenate(values)


def hole_length(sample_time: float) -> float:
    """Return the time between two samples above which a line is interrupted [s].

    Parameters
    ----------
    sample_time : float
        Usual time between two samples [s].
    """
    return max(1.5 * sample_time, SHORTEST_HOLE)


def _segments(
    starts: NDArray[np.intp], breaks: NDArray[np.intp], size: int
) -> tuple[list[int], list[int]]:
    """Return the beginnings and ends of the intervals without column border or interruption."""
    firsts = np.union1d(starts, breaks).tolist()
    return firsts, [*firsts[1:], size]
