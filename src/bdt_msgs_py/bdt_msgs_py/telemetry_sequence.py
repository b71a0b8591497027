"""Batches of telemetry that go on from one to the next, and strays that do not belong to them."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.rejection import MessageRejectedError, Reason
from bdt_msgs_py.time_sequence import SILENCE

LARGEST_HOLE = 1.0
"""Time [s] that lost batches may leave out: by so much a plant in lockstep runs ahead at most."""

STEP_FACTOR = 2.0
"""Factor by which a batch's mean time step may differ from the known one."""

LONGEST_BUNCH = 2.5e-3
"""Time [s] between two samples that is no hole, whatever the sample time: a transport that comes
once in each millisecond stamps samples in bunches."""

FloatArray = NDArray[np.float64]


class Admitted(NamedTuple):
    """Batches to be worked on.

    Attributes
    ----------
    batches : list of ndarray, shape (n, 3)
        One batch in most cases; with the one that came before it when that turns out to be no
        stray, in the order of their times; none while it is unknown.
    begins : bool
        Whether they begin another run.
    stray : MessageRejectedError or None
        Why a batch that was held back is rejected after all.
    hole : ndarray, shape (m, 3), or None
        What came right before them and was of no use.
    """

    batches: list[FloatArray]
    begins: bool = False
    stray: MessageRejectedError | None = None
    hole: FloatArray | None = None


class TelemetrySequence:
    """Tells batches that continue a run from strays, by their times.

    A batch is admitted if it begins where the newest one ended. What begins elsewhere is held
    back until the next batch shows whether it was a stray: if that one continues it, and none in
    sequence came for a while, both are admitted. So is one behind a hole that comes once more: a
    plant in lockstep sends it again when it waits for somebody who has lost the one before. A
    clock that was seen to go back speaks for the first batch of another run.

    Parameters
    ----------
    sample_time : float or None
        Time step [s] if it is known; else the first batch tells it.
    """

    def __init__(self, sample_time: float | None = None) -> None:
        self._step = sample_time
        self._end: float | None = None
        self._admitted_at = 0.0
        self._held: FloatArray | None = None
        self._held_at = 0.0
        self._unusable: FloatArray | None = None
        self._held_quietly = False
        self._clock_went_back = False

    def expect_restart(self) -> Admitted:
        """Note that simulated time has gone back; return the batch that waited for this word."""
        held, self._held = self._held, None
        if held is not None and self._end is not None and held[0, 0] <= self._end:
            return self._admit([held], self._admitted_at)
        self._clock_went_back = self._end is not None
        return Admitted([])

    def note_unusable(self, rows: FloatArray) -> None:
        """Note a batch that is of no use: it leaves a hole if it stands where the next one would.

        The next batch may then begin where this one ended, or where it began if it was a stray.
        """
        if self._end is not None and self._is_next(self._end, float(rows[0, 0])):
            self._unusable = np.array(rows)

    def admit(self, rows: FloatArray, now: float, expected: float | None = None) -> Admitted:
        """Take the next batch, whose times increase.

        Parameters
        ----------
        rows : ndarray, shape (n, 3)
            Telemetry rows (t [s], u [V], q3 [m]), n at least 1.
        now : float
            Wall time [s], of any origin.
        expected : float or None
            Time of the loop [s] if somebody knows it, for the first batch.

        Raises
        ------
        MessageRejectedError
            If the batch does not belong to the sequence.
        """
        self._check_steps(rows)
        begin = float(rows[0, 0])
        if self._end is None:
            is_expected = expected is None or abs(begin - expected) <= LARGEST_HOLE
            is_another_run = is_hole = False
        else:
            is_expected = self._is_next(self._end, begin) or self._hole_before(begin) is not None
            is_another_run = begin <= self._end and self._clock_went_back
            is_hole = self._is_after(self._end, begin)
        held, is_silent = self._held, now - self._admitted_at >= SILENCE
        if is_expected or is_another_run:
            if held is not None and self._is_next(float(rows[-1, 0]), float(held[0, 0])):
                return self._admit([rows, held], now)  # it has overtaken this one
            return self._admit([rows], now, self._stray())
        if held is not None and is_silent and self._is_after(float(held[-1, 0]), begin):
            return self._admit([held, rows], now)
        if held is not None and is_hole and begin == float(held[0, 0]):
            if is_silent and now - self._held_at >= SILENCE:
                return self._admit([rows], now)
            return Admitted([])
        stray = self._stray()
        self._held, self._held_at, self._held_quietly = np.array(rows), now, is_hole
        if not is_hole:
            raise self._rejection(begin)
        return Admitted([], stray=stray)

    def _stray(self) -> MessageRejectedError | None:
        """Return why the batch that is held back is none of the run, if nobody was told."""
        if self._held is None or not self._held_quietly:
            return None
        return self._rejection(float(self._held[0, 0]))

    def _is_next(self, end: float, begin: float) -> bool:
        largest = LARGEST_HOLE if self._step is None else _longest_step(self._step)
        return 0.0 < begin - end <= largest

    def _is_after(self, end: float, begin: float) -> bool:
        """Tell whether a batch may begin there if those before it were lost, but for a sample."""
        largest = LARGEST_HOLE if self._step is None else LARGEST_HOLE + _longest_step(self._step)
        return 0.0 < begin - end <= largest

    def _hole_before(self, begin: float) -> FloatArray | None:
        """Return the batch of no use that ended where this one begins."""
        rows = self._unusable
        if rows is None or self._step is None:
            return None
        end = float(rows[0, 0]) + (len(rows) - 1) * self._step
        return rows if self._is_next(end, begin) else None

    def _rejection(self, begin: float) -> MessageRejectedError:
        if self._end is None:
            return MessageRejectedError(
                Reason.TIME, f"batch from {begin:.9g} s: is far from the time of the loop"
            )
        ahead = begin - self._end
        side = "after" if ahead > 0 else "before"
        return MessageRejectedError(
            Reason.TIME,
            f"batch from {begin:.9g} s: begins {abs(ahead):.9g} s {side} the end of the newest "
            f"accepted, must continue it",
        )

    def _check_steps(self, rows: FloatArray) -> None:
        steps = np.diff(rows[:, 0])
        if not steps.size:
            return
        # The steps of a machine's telemetry differ, and samples may come in bunches.
        mean, largest = float(np.mean(steps)), float(steps.max())
        if self._step is None:
            self._step = mean
        for step, is_wrong in (
            (mean, not self._step / STEP_FACTOR <= mean <= self._step * STEP_FACTOR),
            (largest, largest > _longest_step(self._step)),
        ):
            if is_wrong:
                raise MessageRejectedError(
                    Reason.SAMPLES, f"time step of {step:g} s: must be about {self._step:g} s"
                )

    def _admit(
        self, batches: list[FloatArray], now: float, stray: MessageRejectedError | None = None
    ) -> Admitted:
        begin = float(batches[0][0, 0])
        begins = self._end is not None and begin <= self._end
        hole = self._hole_before(begin)
        self._end, self._admitted_at = float(batches[-1][-1, 0]), now
        self._held = self._unusable = None
        self._clock_went_back = False
        return Admitted(batches, begins, stray, hole)


def _longest_step(sample_time: float) -> float:
    """Return the longest time [s] from one sample to the next that is no hole."""
    return max(STEP_FACTOR * sample_time, LONGEST_BUNCH)
