"""Timing of the loop: whether every message is there, on time, and answered.

Two clocks tell different things. Stamps say for which time a message is; a hole in them is a
message that is missing. Receive times are those of the recorder's wall clock: in real time they
show jitter and latency of the computer, in lockstep only how fast the simulation went.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_bags.reading.recording import Recording
from bdt_bags.reading.recording_clock import MessageTimes

FloatArray = NDArray[np.float64]

MISSING_MESSAGE_PERIODS = 1.5
"""Time between two stamps, in periods, above which a message is missing between them."""


@dataclass(frozen=True)
class StreamTiming:
    """Timing of one topic; the fields of ``timing.measurement`` and others in ``summary.json``.

    Attributes
    ----------
    messages : int
        Number of messages, repeated ones included.
    repeated : int
        Number of messages with a stamp that another one before has.
    period_s : float or None
        Median time between two stamps [s].
    stamp_jitter_rms_s, stamp_jitter_max_s : float or None
        Deviation of the time between two stamps from its median [s], gaps left out.
    arrival_period_s : float or None
        Median time between two receptions [s] of wall clock.
    arrival_jitter_rms_s, arrival_jitter_max_s : float or None
        Deviation of the time between two receptions from its median [s] of wall clock.
    gaps : int
        Number of times between two stamps of more than 1.5 periods.
    longest_gap_s : float or None
        The longest of them [s]; None without one.
    longest_gap_begins_s : float or None
        Stamp before it [s].
    """

    messages: int
    repeated: int
    period_s: float | None
    stamp_jitter_rms_s: float | None
    stamp_jitter_max_s: float | None
    arrival_period_s: float | None
    arrival_jitter_rms_s: float | None
    arrival_jitter_max_s: float | None
    gaps: int
    longest_gap_s: float | None
    longest_gap_begins_s: float | None


@dataclass(frozen=True)
class LatencyTiming:
    """Time from a measurement to its command; the fields of ``timing.latency``.

    Attributes
    ----------
    answered, unanswered : int
        Number of measurements with and without a command of the same stamp.
    median_s, p99_s, max_s : float or None
        Time from the reception of a measurement to that of its command [s] of wall clock, as the
        recorder saw them.
    """

    answered: int
    unanswered: int
    median_s: float | None
    p99_s: float | None
    max_s: float | None


@dataclass(frozen=True)
class LoopTiming:
    """Timing of the loop; the fields of ``timing`` in ``summary.json``.

    Attributes
    ----------
    measurement, command, telemetry : StreamTiming
        The three topics; a batch of telemetry has the stamp of its last row.
    latency : LatencyTiming
        From a measurement to its command.
    """

    measurement: StreamTiming
    command: StreamTiming
    telemetry: StreamTiming
    latency: LatencyTiming


def summarize_timing(recording: Recording) -> LoopTiming:
    """Return the timing of a recording.

    Parameters
    ----------
    recording : Recording
        A loaded bag.
    """
    latencies = command_latencies(recording.measurements, recording.commands)[:, 1]
    asked = int(np.unique(recording.measurements.stamps).size)
    return LoopTiming(
        measurement=stream_timing(recording.measurements),
        command=stream_timing(recording.commands),
        telemetry=stream_timing(recording.batches),
        latency=LatencyTiming(
            answered=latencies.size,
            unanswered=asked - latencies.size,
            median_s=float(np.median(latencies)) if latencies.size else None,
            p99_s=float(np.percentile(latencies, 99)) if latencies.size else None,
            max_s=float(latencies.max()) if latencies.size else None,
        ),
    )


def stream_timing(times: MessageTimes) -> StreamTiming:
    """Return period, jitter and gaps of a topic.

    Parameters
    ----------
    times : MessageTimes
        Stamps and receive times [s]; messages may be repeated or out of order.
    """
    stamps = np.unique(times.stamps)
    intervals = np.diff(stamps)
    period, rms, largest = _spread(intervals, MISSING_MESSAGE_PERIODS)
    arrival, arrival_rms, arrival_largest = _spread(np.diff(np.sort(times.received)))
    gaps = intervals > MISSING_MESSAGE_PERIODS * period if period else np.zeros(0, np.bool_)
    longest = int(intervals.argmax()) if gaps.any() else None
    return StreamTiming(
        messages=times.stamps.size,
        repeated=times.stamps.size - stamps.size,
        period_s=period,
        stamp_jitter_rms_s=rms,
        stamp_jitter_max_s=largest,
        arrival_period_s=arrival,
        arrival_jitter_rms_s=arrival_rms,
        arrival_jitter_max_s=arrival_largest,
        gaps=int(gaps.sum()),
        longest_gap_s=None if longest is None else float(intervals[longest]),
        longest_gap_begins_s=None if longest is None else float(stamps[longest]),
    )


def command_latencies(measurements: MessageTimes, commands: MessageTimes) -> FloatArray:
    """Return how long each measurement waited for its command.

    A command carries the stamp of the measurement that it answers. Of a command that was sent
    twice the first reception counts; of a measurement that was sent again, the last one before
    the command. A recorder may see a command before its measurement; then the time is negative.

    Parameters
    ----------
    measurements, commands : MessageTimes
        Stamps and receive times [s].

    Returns
    -------
    ndarray, shape (k, 2)
        Rows of (stamp [s], latency [s]) in the order of stamps, one for each stamp that both have.
    """
    order = np.lexsort((measurements.received, measurements.stamps))
    stamps, received = measurements.stamps[order], measurements.received[order]
    by_stamp = np.lexsort((commands.received, commands.stamps))
    answered, first = np.unique(commands.stamps[by_stamp], return_index=True)
    replied = commands.received[by_stamp][first]
    begin, end = (np.searchsorted(stamps, answered, side=side) for side in ("left", "right"))
    known = begin < end
    begin, end, answered, replied = begin[known], end[known], answered[known], replied[known]
    last = end - 1
    for k in np.flatnonzero(last > begin).tolist():
        before = int(np.searchsorted(received[begin[k] : end[k]], replied[k], side="right"))
        last[k] = begin[k] + max(before - 1, 0)
    return np.stack([answered, replied - received[last]], axis=1)


def _spread(
    intervals: FloatArray, cut: float = np.inf
) -> tuple[float | None, float | None, float | None]:
    """Return median, and rms and largest deviation from it, of what is below `cut` medians."""
    if not intervals.size:
        return None, None, None
    median = float(np.median(intervals))
    deviation = (
        intervals[intervals <= cut * median] - median if cut < np.inf else intervals - median
    )
    return median, float(np.sqrt(np.mean(deviation**2))), float(np.abs(deviation).max())
