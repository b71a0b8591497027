"""Stretches of a run of which nothing is known, or in which nobody controlled: not to be judged."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_analysis.metrics.missing_samples import LONGEST_INTERPOLATION
from bdt_analysis.metrics.performance_output import performance_output
from bdt_bags.reading.recording import Recording
from bdt_msgs_py.topics import COMMAND, MEASUREMENT, TELEMETRY

FloatArray = NDArray[np.float64]

LONGEST_SILENCE = 0.1
"""Longest time without a command [s] that belongs to the loop, as a computer that is late does:
less than a period of the structure."""

FIRST_COMMAND = 1.0
"""Time [s] within which a recorder that comes to a running loop has found all of its topics."""

_PERIODS = 2.5
"""So many periods make no hole: one message that is missing."""

MOST_LINES = 5
"""Number of holes that are told one by one."""


@dataclass(frozen=True)
class RecordingHole:
    """A stretch without samples or commands; an entry of ``holes`` in ``summary.json``.

    Attributes
    ----------
    topic : str
        What is missing.
    begins_s, ends_s : float
        Times of the last sample or stamp before and of the first one behind it [s]; begin and end
        of the telemetry where there is none.
    """

    topic: str
    begins_s: float
    ends_s: float

    @property
    def length(self) -> float:
        """Length [s]."""
        return self.ends_s - self.begins_s


def find_holes(recording: Recording) -> tuple[RecordingHole, ...]:
    """Return the holes of a recording in the order of time.

    Samples are missing for longer than the analysis bridges, see
    :func:`bdt_analysis.metrics.missing_samples.interpolate_missing_samples`; commands for longer
    than :data:`LONGEST_SILENCE`. Of a regular topic one message alone makes no hole.

    Parameters
    ----------
    recording : Recording
        A loaded bag.
    """
    rows, sample_time = performance_output(recording)
    longest = max(LONGEST_INTERPOLATION, _PERIODS * sample_time)
    topic = TELEMETRY if recording.batch_rows else MEASUREMENT
    found = [RecordingHole(topic.name, *gap) for gap in _gaps(rows[:, 0], longest)]
    stamps = np.unique(recording.commands.stamps)
    if stamps.size > 1:
        longest = max(LONGEST_SILENCE, _PERIODS * float(np.median(np.diff(stamps))))
        end = max(float(recording.sample_times[-1]), float(stamps[-1]))
        gaps = [*_gaps(np.append(stamps, end), longest)]
        begin = float(recording.sample_times[0])
        if stamps[0] > begin + FIRST_COMMAND:
            gaps.insert(0, (begin, float(stamps[0])))
        found += [RecordingHole(COMMAND.name, *gap) for gap in gaps]
    return tuple(sorted(found, key=lambda hole: hole.begins_s))


def unrecorded(holes: Sequence[RecordingHole]) -> tuple[RecordingHole, ...]:
    """Return the holes in which nothing was recorded; without a command others may still speak."""
    return tuple(hole for hole in holes if hole.topic != COMMAND.name)


def hole_limits(holes: Sequence[RecordingHole]) -> FloatArray:
    """Return begin and end of holes [s], shape (k, 2)."""
    return np.array([(hole.begins_s, hole.ends_s) for hole in holes]).reshape(-1, 2)


def hole_lines(holes: Sequence[RecordingHole]) -> tuple[str, ...]:
    """Return what is missing and what follows from it, in a few lines."""
    lines = [
        f"no {hole.topic} from t = {hole.begins_s:.6g} to {hole.ends_s:.6g} s: "
        "a step with such a hole is not judged"
        for hole in holes[:MOST_LINES]
    ]
    if len(holes) > MOST_LINES:
        rest = sum(hole.length for hole in holes[MOST_LINES:])
        lines.append(f"{len(holes) - MOST_LINES} more holes of {rest:.3g} s together")
    return tuple(lines)


def _gaps(times: FloatArray, longest: float) -> Iterator[tuple[float, float]]:
    for place in np.flatnonzero(np.diff(times) > longest).tolist():
        yield float(times[place]), float(times[place + 1])
