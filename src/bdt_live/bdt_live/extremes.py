"""Running signals as rows for a plot: few, and without losing an extreme."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_live.held_value import HeldValue

FloatArray = NDArray[np.float64]

BUCKET = 0.01
"""Time that a row stands for [s]."""

PATIENCE = 0.2
"""Time [s] by which telemetry is ahead of the truth from which on no truth is expected."""

COLUMNS = (
    "time",
    "voltage_first",
    "voltage_second",
    "position_first",
    "position_second",
    "position",
    "theta_m",
    "theta_d",
    "gap",
    "q1",
    "q2",
    "reference",
    "dead_zone",
    "estimate",
    "uncertainty",
)
"""What a row holds, in SI units: both extremes of voltage and measured position in the order in
which they came, the latest of everything else, None for what is not known."""

HELD = COLUMNS[-4:]
"""Columns of what holds until it is said anew."""

_DIGITS = 7


def extremes(values: FloatArray) -> tuple[float, float]:
    """Return smallest and largest of some values in the order in which they come.

    Parameters
    ----------
    values : ndarray, shape (n,)
        At least one; NaN is the extreme of values that hold one.
    """
    low, high = int(values.argmin()), int(values.argmax())
    first, second = sorted((low, high))
    return float(values[first]), float(values[second])


class RowMaker:
    """Makes a row of every ``BUCKET`` of time from batches of telemetry and truth.

    Attributes
    ----------
    gap : float or None
        The latest true gap [rad].
    """

    def __init__(self) -> None:
        self._held = {name: HeldValue() for name in HELD}
        self.gap: float | None = None
        self.restart()

    def restart(self) -> None:
        """Forget the samples: time begins anew."""
        self._telemetry, self._truth = np.empty((0, 3)), np.empty((0, 7))
        self._telemetry_end = self._truth_end = -math.inf
        for held in self._held.values():
            held.restart()

    def hold(self, name: str, time: float, value: float | None) -> None:
        """Take what holds from a time on [s], one of ``HELD``; it may come before its samples."""
        self._held[name].say(time, value)

    def take_telemetry(self, rows: FloatArray) -> None:
        """Take rows of (t [s], u [V], q3 [m]); those that go back in time begin a new run."""
        if rows[0, 0] < self._telemetry_end:
            self.restart()
        self._telemetry = np.concatenate([self._telemetry, rows])
        self._telemetry_end = float(rows[-1, 0])

    def take_truth(self, rows: FloatArray) -> None:
        """Take rows of (t, theta_m, theta_d, gap, q1, q2, q3) [s, rad, m]."""
        self._truth = np.concatenate([self._truth, rows])
        self._truth_end, self.gap = float(rows[-1, 0]), float(rows[-1, 3])

    def rows(self) -> list[list[float | None]]:
        """Return the rows that are complete, oldest first, and forget what they are made of."""
        end = self._telemetry_end
        if self._truth_end > end - PATIENCE:
            end = min(end, self._truth_end)
        if not len(self._telemetry) or end <= self._telemetry[0, 0]:
            return []
        # A bucket is complete when a sample of the next one is there.
        buckets = _buckets(self._telemetry[:, 0])
        complete = int(np.searchsorted(buckets, _buckets(np.array([end]))[0]))
        if not complete:
            return []
        truth_buckets = _buckets(self._truth[:, 0])
        made = []
        bounds = np.flatnonzero(np.diff(buckets[:complete], prepend=-1)).tolist()
        for begin, stop in zip(bounds, [*bounds[1:], complete], strict=True):
            number = buckets[begin]
            known = int(np.searchsorted(truth_buckets, number, side="right"))
            is_known = known > 0 and truth_buckets[known - 1] == number
            made.append(
                self._row(
                    float(number * BUCKET),
                    self._telemetry[begin:stop],
                    self._truth[known - 1] if is_known else None,
                )
            )
        self._telemetry = self._telemetry[complete:]
        used = np.searchsorted(truth_buckets, buckets[complete - 1], side="right")
        self._truth = self._truth[used:]
        return made

    def _row(
        self, time: float, samples: FloatArray, truth: FloatArray | None
    ) -> list[float | None]:
        values: list[float | None] = [
            *extremes(samples[:, 1]),
            *extremes(samples[:, 2]),
            float(samples[-1, 2]),
        ]
        values += [None] * 5 if truth is None else truth[1:6].tolist()
        values += [self._held[name].at(float(samples[-1, 0])) for name in HELD]
        return [round(time, 6), *(None if each is None else rounded(each) for each in values)]


def rounded(value: float) -> float | None:
    """Return a number with as many digits as a plot can show; None for one that is not finite."""
    return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None


def _buckets(times: FloatArray) -> NDArray[Any]:
    # A sample on a border belongs to the bucket that begins there, whatever its last bit says.
    return np.floor(times / BUCKET + 1e-6).astype(np.int64)
