"""Messages that a recording should hold and does not."""

import math

import numpy as np
from numpy.typing import NDArray

from bdt_bringup.bags.recording import Recording

FloatArray = NDArray[np.float64]


def lost_messages(recording: Recording) -> int:
    """Return how many measurements, commands and telemetry batches are missing.

    Stamps lie on a regular grid, so holes in it are countable. A recording that begins at time
    zero begins with the run: there, what is missing at the beginning counts too. What is missing
    at the end counts as far as other topics reach. A topic that was not recorded is not lost,
    and a message that was sent twice is not missing.

    Parameters
    ----------
    recording : Recording
        A loaded bag.
    """
    streams = [x.stamps for x in (recording.measurements, recording.commands) if x.stamps.size]
    times = recording.sample_times
    first_stamp = min((float(stamps.min()) for stamps in streams), default=math.nan)
    last_stamp = max((float(stamps.max()) for stamps in streams), default=math.nan)
    begin = first = math.nan
    if min(abs(times[0]), abs(first_stamp)) < recording.sample_time or times[0] == 0.0:
        begin = first = 0.0
        # In real time the first measurement comes one period after the first sample.
        if first_stamp < 1.5 * min((_period(stamps) for stamps in streams), default=0.0):
            first = first_stamp
    lost = sum(missing_stamps(stamps, first, float(times[-1])) for stamps in streams)
    if not recording.batch_rows:
        return lost
    return lost + missing_batches(times, recording.batch_rows, begin, last_stamp)


def missing_stamps(stamps: FloatArray, begin: float, end: float) -> int:
    """Return the number of holes in a regular grid of stamps.

    Parameters
    ----------
    stamps : ndarray, shape (k,)
        Stamps [s] in any order, repeated ones included.
    begin : float
        Time of the first stamp that there should be [s]; NaN if that is unknown.
    end : float
        Time up to which there should be stamps [s].
    """
    grid = np.unique(stamps)
    if grid.size < 2:
        return 0
    period = _period(stamps)
    missing = int(np.maximum(np.round(np.diff(grid) / period) - 1, 0).sum())
    if not math.isnan(begin):
        missing += max(round((float(grid[0]) - begin) / period), 0)
    # A thousandth of a period of room: `end` may be the time of a stamp, rounded differently.
    return missing + max(math.floor((end - float(grid[-1])) / period + 1e-3), 0)


def missing_batches(times: FloatArray, batch_rows: int, begin: float, last_stamp: float) -> int:
    """Return the number of telemetry messages that are missing.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Times of the samples [s], strictly increasing.
    batch_rows : int
        Number of samples of a message.
    begin : float
        Time of the first sample that there should be [s]; NaN if that is unknown.
    last_stamp : float
        Time up to which the loop is known to have run [s]; NaN if that is unknown.
    """
    gaps = np.diff(times)
    sample_time = float(np.median(gaps))
    holes = np.round(gaps / sample_time) - 1
    missing = int(np.ceil(holes[holes > 0] / batch_rows).sum())
    if not math.isnan(begin):
        missing += math.ceil(round((times[0] - begin) / sample_time) / batch_rows)
    if not math.isnan(last_stamp):
        # The batch that was not full yet at the end was never sent.
        rest = round((last_stamp - times[-1]) / sample_time) - 1
        missing += max(rest // batch_rows, 0)
    return missing


def _period(stamps: FloatArray) -> float:
    """Return the usual time between two stamps [s]; infinite when there is only one."""
    gaps = np.diff(np.unique(stamps))
    return float(np.median(gaps)) if gaps.size else math.inf
