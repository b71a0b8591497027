"""Messages that a recording should hold and does not."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_bags.reading.recording import Recording
from bdt_bags.reading.recording_clock import MessageTimes
from bdt_msgs_py.topics import COMMAND, MEASUREMENT, TELEMETRY

FloatArray = NDArray[np.float64]

_LATE_PERIODS = 1.5
"""In real time the first measurement comes one period after the first sample."""

_BURST = 3
"""Messages that come at once where a queue is emptied."""

_BURST_TIME = 0.5
"""Time within which they come then, in usual times between two messages."""


class LostMessages(NamedTuple):
    """Holes in a recording.

    Attributes
    ----------
    total : int
        Number of measurements, commands and telemetry batches that are missing.
    in_queue : int
        Those of them that a queue of the recorder has lost, which was late: what follows the hole
        came all at once.
    """

    total: int
    in_queue: int


def lost_messages(recording: Recording) -> LostMessages:
    """Return how many measurements, commands and telemetry batches are missing.

    Stamps lie on a regular grid, so holes in it are countable. What is missing at the end counts
    as far as other topics reach. What came before the first message of a topic that was recorded
    is not lost: the recorder was not there yet, see :func:`late_beginnings`. A topic that was not
    recorded is not lost either, and a message that was sent twice is not missing. A command answers
    a measurement: where a measurement is missing, its command counts only if a queue has lost it.

    Parameters
    ----------
    recording : Recording
        A loaded bag.
    """
    streams = [x for x in (recording.measurements, recording.commands) if x.stamps.size]
    times = recording.sample_times
    end = float(times[-1])
    if len(streams) == 2:
        total, in_queue = missing_in_loop(streams[0], streams[1], end)
    else:
        total = sum(missing_stamps(stream.stamps, end) for stream in streams)
        in_queue = sum(map(lost_in_queue, streams))
    if recording.batch_rows:
        last_stamp = max((float(stream.stamps.max()) for stream in streams), default=math.nan)
        total += missing_batches(times, recording.batch_rows, last_stamp)
    return LostMessages(total, in_queue)


def late_beginnings(recording: Recording) -> tuple[str, ...]:
    """Return which topics begin later than the others, in words.

    Parameters
    ----------
    recording : Recording
        A loaded bag.
    """
    firsts: dict[str, tuple[float, float]] = {}
    for topic, stream in ((MEASUREMENT, recording.measurements), (COMMAND, recording.commands)):
        if stream.stamps.size:
            firsts[topic.name] = float(stream.stamps.min()), _period(stream.stamps)
    if recording.batch_rows:
        batch = recording.batch_rows * recording.sample_time
        firsts[TELEMETRY.name] = float(recording.sample_times[0]), batch
    begin = min(first for first, _ in firsts.values())
    return tuple(
        f"no {name} before t = {first:.6g} s: the recorder came later"
        for name, (first, period) in firsts.items()
        if math.isfinite(period) and first - begin > _LATE_PERIODS * period
    )


def missing_in_loop(
    measurements: MessageTimes, commands: MessageTimes, end: float
) -> tuple[int, int]:
    """Return how many measurements and commands are missing, and how many of them in a queue.

    Parameters
    ----------
    measurements, commands : MessageTimes
        What was recorded.
    end : float
        Time up to which there should be stamps [s].
    """
    asked, answered = np.unique(measurements.stamps), np.unique(commands.stamps)
    holes = missing_stamps(asked, end), missing_stamps(answered, end)
    in_queue = lost_in_queue(measurements), lost_in_queue(commands)
    expected = asked[(asked >= answered[0]) & (asked <= end)]
    # A thousandth of a period of room: the stamps of both may be rounded differently.
    room = 1e-3 * _period(asked)
    nearest = answered[np.clip(np.searchsorted(answered, expected - room), 0, answered.size - 1)]
    unanswered = int((np.abs(nearest - expected) > room).sum())
    unasked = max(holes[1] - unanswered, 0)
    return holes[0] + unanswered + min(unasked, in_queue[1]), sum(in_queue)


def missing_stamps(stamps: FloatArray, end: float) -> int:
    """Return the number of holes in a regular grid of stamps.

    Parameters
    ----------
    stamps : ndarray, shape (k,)
        Stamps [s] in any order, repeated ones included.
    end : float
        Time up to which there should be stamps [s].
    """
    grid = np.unique(stamps)
    if grid.size < 2:
        return 0
    # A thousandth of a period of room: `end` may be the time of a stamp, rounded differently.
    rest = max(math.floor((end - float(grid[-1])) / _period(stamps) + 1e-3), 0)
    return int(_holes(grid).sum()) + rest


def missing_batches(times: FloatArray, batch_rows: int, last_stamp: float) -> int:
    """Return the number of telemetry messages that are missing.

    Parameters
    ----------
    times : ndarray, shape (n,)
        Times of the samples [s], strictly increasing.
    batch_rows : int
        Number of samples of a message.
    last_stamp : float
        Time up to which the loop is known to have run [s]; NaN if that is unknown.
    """
    gaps = np.diff(times)
    sample_time = float(np.median(gaps))
    holes = np.round(gaps / sample_time) - 1
    missing = int(np.ceil(holes[holes > 0] / batch_rows).sum())
    if not math.isnan(last_stamp):
        # The batch that was not full yet at the end was never sent.
        rest = round((last_stamp - times[-1]) / sample_time) - 1
        missing += max(rest // batch_rows, 0)
    return missing


def lost_in_queue(stream: MessageTimes) -> int:
    """Return how many messages a queue has lost: the next ones came all at once.

    A recorder that gets no processor for longer than its queue holds loses the oldest messages
    in it. What is lost on a network leaves the others at their pace.

    Parameters
    ----------
    stream : MessageTimes
        Stamps and receive times of a topic.
    """
    grid, first = np.unique(stream.stamps, return_index=True)
    if grid.size <= _BURST + 1:
        return 0
    received = stream.received[first]
    holes = _holes(grid)[:-_BURST]
    burst = received[1 + _BURST :] - received[1:-_BURST]
    usual = float(np.median(np.diff(np.sort(received))))
    return int(holes[np.abs(burst) < _BURST_TIME * usual].sum())


def _holes(grid: FloatArray) -> NDArray[np.int64]:
    """Return the number of stamps that are missing behind each but the last."""
    steps = np.diff(grid)
    return np.maximum(np.round(steps / np.median(steps)) - 1, 0).astype(np.int64)


def _period(stamps: FloatArray) -> float:
    """Return the usual time between two stamps [s]; infinite when there is only one."""
    gaps = np.diff(np.unique(stamps))
    return float(np.median(gaps)) if gaps.size else math.inf
