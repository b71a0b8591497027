"""The steps of a run: where the reference changes, by how much, and what can be judged."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

WINDOW = 3.0
"""Length [s] of the end of a step on which its residual, bias and oscillation are taken."""

NEGLIGIBLE_HEIGHT = 1e-3
"""A step lower than this part of the highest one is none."""

MISSED_BEGINNING = 0.1
"""Part of a step that may be missing at the beginning of a recording."""

MOTION = 0.05
"""Time [s] between two changes of the reference below which they are parts of one step: a ramp."""

NO_HOLES: FloatArray = np.empty((0, 2))


@dataclass(frozen=True)
class ReferenceStep:
    """An interval with a constant reference, after it has moved there at once or as a ramp.

    Attributes
    ----------
    t_start, t_end : float
        Beginning and end [s]; the end of the last step is that of the telemetry.
    reference : float
        Reference r [m].
    height : float or None
        Change of the reference, without sign [m]; for the first step, and the first behind a hole,
        its distance from the first q3. None when the beginning of the step was not recorded or
        when nothing changed.
    scale : float or None
        Height on which an oscillation is judged [m]: its own or, without one, that of the
        highest step or, if no step has any, the largest reference.
    window : float
        Length of the end on which the step is judged [s]: 3 s, or half of the time for which a
        reference holds that is constant for less than 6 s, so that a window never begins with the
        transient at full size.
    cut : bool
        True for a last step that the end of the recording cuts too short to be judged.
    holed : bool
        True when a part of it was not recorded or not controlled.
    """

    t_start: float
    t_end: float
    reference: float
    height: float | None
    scale: float | None
    window: float
    cut: bool
    holed: bool = False

    @property
    def length(self) -> float:
        """Length [s]."""
        return self.t_end - self.t_start


def find_steps(
    reference: FloatArray,
    telemetry: FloatArray,
    sample_time: float,
    holes: FloatArray = NO_HOLES,
) -> list[ReferenceStep]:
    """Return the steps of a run.

    The last step is cut by the end of the recording. It can still be judged if it is at least
    6 s long or as long as the shortest of the others.

    In a hole the reference may have changed. So the first one that is known behind it begins a
    step, whose height is its distance from q3 there.

    Parameters
    ----------
    reference : ndarray, shape (k, 2)
        Rows of (time from which it holds [s], r [m]) in the order of time.
    telemetry : ndarray, shape (n, 3)
        Rows of (t [s], u [V], q3 [m]).
    sample_time : float
        Sample time of the telemetry [s].
    holes : ndarray, shape (h, 2)
        Begin and end of stretches that were not recorded or not controlled [s].

    Returns
    -------
    list of ReferenceStep
        In the order of time; empty when no reference holds during the telemetry.
    """
    if not len(reference):
        return []
    begin, end = telemetry[0, 0], telemetry[-1, 0] + sample_time
    rows, reached, unsure = _changes(reference, holes[:, 0])
    # A step shorter than a sample time was never seen by the controller.
    ends = np.append(rows[1:, 0], end)
    inside = (ends > begin + 0.5 * sample_time) & (rows[:, 0] < end - 0.5 * sample_time)
    rows, reached, unsure = rows[inside], reached[inside], unsure[inside]
    ends = np.minimum(ends[inside], end)
    if not len(rows):
        return []
    heights = _heights(rows, ends, unsure, telemetry)
    highest = float(np.nanmax(heights, initial=0.0))
    largest = float(np.abs(rows[:, 1]).max())
    if highest <= NEGLIGIBLE_HEIGHT * largest:
        highest = 0.0  # the run begins where it stays
    known = heights > NEGLIGIBLE_HEIGHT * highest
    lengths = ends - np.maximum(rows[:, 0], begin)
    holds = np.maximum(ends - np.maximum(reached, begin), 0.0)
    enough = min(2 * WINDOW, lengths[:-1].min(initial=np.inf)) if len(rows) > 1 else 0.0
    steps = []
    for k, (start, value) in enumerate(rows.tolist()):
        height = float(heights[k]) if known[k] and highest else None
        scale = height or highest or largest or None
        steps.append(
            ReferenceStep(
                t_start=start,
                t_end=float(ends[k]),
                reference=value,
                height=height,
                scale=scale,
                window=judged_time(float(holds[k])),
                cut=k == len(rows) - 1 and bool(lengths[k] < enough - sample_time),
                holed=bool(((holes[:, 0] < ends[k]) & (holes[:, 1] > start)).any()),
            )
        )
    return steps


def judged_time(holds: float) -> float:
    """Return the time [s] at the end of a step on which it is judged.

    Parameters
    ----------
    holds : float
        Time for which its reference is constant [s].
    """
    return min(WINDOW, 0.5 * holds)


def _changes(
    reference: FloatArray, holes: FloatArray
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Return the steps' beginnings and values, when each is reached, and which follow a hole.

    Of several rows at one time the last one holds, and of several in a row that are no further
    apart than those of a ramp.
    """
    last_of_time = np.append(np.diff(reference[:, 0]) > 0, True)
    rows = reference[last_of_time]
    behind = np.searchsorted(rows[:, 0], holes, side="right")
    unsure = np.zeros(len(rows), dtype=np.bool_)
    unsure[behind[behind < len(rows)]] = True
    changed = np.concatenate([[True], np.diff(rows[:, 1]) != 0]) | unsure
    rows, unsure = rows[changed], unsure[changed]
    first = np.flatnonzero(np.concatenate([[True], np.diff(rows[:, 0]) > MOTION]) | unsure)
    last = np.append(first[1:], len(rows)) - 1
    steps = np.stack([rows[first, 0], rows[last, 1]], axis=1)
    return steps, rows[last, 0], unsure[first]


def _heights(
    rows: FloatArray, ends: FloatArray, unsure: NDArray[np.bool_], telemetry: FloatArray
) -> FloatArray:
    """Return the heights [m], NaN for a first step whose beginning is missing."""
    heights = np.concatenate([[np.nan], np.abs(np.diff(rows[:, 1]))])
    for k in {0, *np.flatnonzero(unsure).tolist()}:
        start, value = rows[k]
        first = min(int(np.searchsorted(telemetry[:, 0], start)), len(telemetry) - 1)
        missed = telemetry[first, 0] - start
        known = missed <= MISSED_BEGINNING * (ends[k] - start)
        heights[k] = abs(value - telemetry[first, 2]) if known else np.nan
    return heights
