"""Telemetry as machines have it, brought to even samples: stamps with jitter, clocks that are off.

Estimators simulate from sample to sample, and telemetry of a simulator passes as it is. That of a
machine is interpolated, from its first uneven batch on:

- positions by the cubic through the four readings around an instant;
- voltages by their mean over a sample, as each holds until the next one: what the motor gets as a
  whole remains.

A stamp that is off may mean two things. Either the sample was taken then, or it was taken by an
even clock and stamped late, by a busy computer. The readings tell: between its neighbors a
position lies nearer to a straight line over the times at which it was really taken.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.telemetry_sequence import LONGEST_BUNCH
from bdt_twin.clock_line import ClockLine
from bdt_twin.fixed_order import dot, mean
from bdt_twin.telemetry_stream import step_tolerance

FloatArray = NDArray[np.float64]

LONGEST_STEPS = 3.5
"""Sample times between two samples that are interpolated; more is a hole, but for bunches."""
LARGEST_RATE_ERROR, MANY = 0.05, 100
"""Share by which a clock may be off, as the mean over many steps tells: more is another rate, which
nobody meant to be interpolated."""
NEIGHBORS = 4
"""Readings that the cubic goes through."""
EVEN_IS_SMOOTHER = 0.9
"""Ratio of the positions' roughness below which samples were taken evenly, whatever the stamps."""


class Sampling(NamedTuple):
    """What was made of the stamps.

    Attributes
    ----------
    is_even : bool
        Whether all samples were even, and were left as they are.
    jitter : float
        Standard deviation of the stamps from an even clock's [s].
    rate : float
        Samples in a second, by the stamps [Hz].
    by_stamps : bool
        Whether samples are thought to be taken when the stamps say, not by an even clock.
    """

    is_even: bool
    jitter: float
    rate: float
    by_stamps: bool

    def __str__(self) -> str:
        if self.is_even:
            return "even"
        taken = "taken when the stamps say" if self.by_stamps else "taken evenly"
        return f"interpolated: {self.rate:.6g} Hz, jitter {1e6 * self.jitter:.3g} us, {taken}"


class EvenSamples:
    """Brings batches of telemetry to even samples.

    Parameters
    ----------
    sampling_rate : float
        Sampling rate of what is returned [Hz]; that of the telemetry may differ.

    Attributes
    ----------
    sampling : Sampling
        What was made of the stamps.
    """

    def __init__(self, sampling_rate: float) -> None:
        self._rate = sampling_rate
        self._longest = _longest_step(sampling_rate)
        self.restart()

    def restart(self) -> None:
        """Forget everything: another run begins."""
        self.sampling = Sampling(True, 0.0, self._rate, True)
        self._roughness = np.zeros(2)
        self._begin(np.empty((0, 3)))

    def _begin(self, rows: FloatArray) -> None:
        """Begin with what was sampled right before."""
        self._line = ClockLine(self._rate)
        self._newest, self._newest_stamp = rows, -np.inf
        self._anchor, self._count = 0.0, 0

    def take(self, rows: FloatArray) -> FloatArray:
        """Return the samples that are known now, maybe none.

        Parameters
        ----------
        rows : ndarray, shape (n, 3)
            Telemetry rows (t [s], u [V], q3 [m]), oldest first.

        Returns
        -------
        ndarray, shape (m, 3)
            The same rows if they are even, else such that are. What no estimator can use, because
            of a hole within or of times that go back, is returned as it is, too.
        """
        if not len(rows) or not np.isfinite(rows).all():
            self._begin(np.empty((0, 3)))
            return rows
        steps = np.diff(rows[:, 0]) * self._rate
        tolerance = step_tolerance(rows[:, 0], 1.0 / self._rate) * self._rate
        is_even = bool((np.abs(steps - 1.0) <= tolerance).all())
        if self.sampling.is_even and is_even:
            self._newest, self._newest_stamp = rows[-NEIGHBORS:].copy(), float(rows[-1, 0])
            return rows
        if not self._is_usable(steps):
            self._begin(np.empty((0, 3)))
            return rows
        if self._newest.size:
            step = (float(rows[0, 0]) - self._newest_stamp) * self._rate
            if not 0.0 < step <= self._longest:
                self._begin(np.empty((0, 3)))
        self._newest_stamp = float(rows[-1, 0])
        return self._interpolated(rows)

    def _is_usable(self, steps: FloatArray) -> bool:
        """Tell whether samples with these steps, in sample times, can be interpolated."""
        if not steps.size:
            return True
        is_another_rate = steps.size >= MANY and abs(mean(steps) - 1.0) > LARGEST_RATE_ERROR
        is_whole = float(steps.min()) > 0.0 and float(steps.max()) <= self._longest
        return is_whole and not is_another_rate

    def _interpolated(self, rows: FloatArray) -> FloatArray:
        self._judge(np.concatenate([self._newest[-2:], rows]))
        times = self._times(rows[:, 0])
        if self._count == 0:
            # What was passed on as it is, is followed by what is interpolated.
            self._count = int(self._newest.size > 0)
            self._anchor = float(self._newest[-1, 0] if self._newest.size else times[0])
        known = np.concatenate([self._newest, np.column_stack([times, rows[:, 1:]])])
        end = min(float(known[-2, 0]), float(known[-1, 0]) - 1.0 / self._rate)
        last = int(np.floor((end - self._anchor) * self._rate))
        if len(known) < NEIGHBORS or last < self._count:
            self._newest = known
            return np.empty((0, 3))
        instants = self._anchor + np.arange(self._count, last + 2) / self._rate
        even = np.empty((instants.size - 1, 3))
        even[:, 0] = instants[:-1]
        even[:, 1] = held_means(known[:, 0], known[:, 1], instants)
        even[:, 2] = cubic(known[:, 0], known[:, 2], instants[:-1])
        self._count = last + 1
        needed = int(np.searchsorted(known[:, 0], instants[-1], side="right")) - NEIGHBORS // 2
        self._newest = known[max(min(needed, len(known) - NEIGHBORS), 0) :]
        return even

    def _times(self, stamps: FloatArray) -> FloatArray:
        """Return when samples were taken, after all that came before."""
        line = self._line.times(stamps)
        by_stamps = self.sampling.by_stamps
        self.sampling = Sampling(False, self._line.jitter, self._line.rate, by_stamps)
        times = stamps if by_stamps else line
        if not self._newest.size:
            return times
        # The line is drawn anew with each batch, and may lie a little behind.
        least = float(self._newest[-1, 0]) + 0.01 / self._rate * np.arange(1, times.size + 1)
        later: FloatArray = np.maximum(times, least)
        return later

    def _judge(self, rows: FloatArray) -> None:
        """Find out whether samples were taken when their stamps say, or evenly."""
        if len(rows) < 3:
            return
        times, position = rows[:, 0], rows[:, 2]
        share = (times[1:-1] - times[:-2]) / (times[2:] - times[:-2])
        for which, place in enumerate((share, np.full(share.size, 0.5))):
            off = position[1:-1] - (1.0 - place) * position[:-2] - place * position[2:]
            self._roughness[which] += dot(off, off)
        by_stamps, evenly = self._roughness.tolist()
        self.sampling = self.sampling._replace(
            by_stamps=bool(evenly >= EVEN_IS_SMOOTHER * by_stamps)
        )


def split_at_holes(rows: FloatArray, sampling_rate: float) -> list[FloatArray]:
    """Return the parts of telemetry between its holes.

    Parameters
    ----------
    rows : ndarray, shape (n, 3)
        Telemetry rows (t [s], u [V], q3 [m]), oldest first.
    sampling_rate : float
        Sampling rate [Hz].
    """
    steps = np.diff(rows[:, 0]) * sampling_rate
    parts: list[FloatArray] = np.split(
        rows, np.flatnonzero(steps > _longest_step(sampling_rate)) + 1
    )
    return parts


def _longest_step(sampling_rate: float) -> float:
    """Return the longest time between two samples that are interpolated, in sample times."""
    return max(LONGEST_STEPS, LONGEST_BUNCH * sampling_rate)


def held_means(times: FloatArray, values: FloatArray, instants: FloatArray) -> FloatArray:
    """Return the mean between instants of values that hold until the next one.

    Parameters
    ----------
    times, values : ndarray, shape (n,)
        When each value begins to hold [s], and the values.
    instants : ndarray, shape (m + 1,)
        Increasing, within the times [s].

    Returns
    -------
    ndarray, shape (m,)
    """
    integral = np.concatenate([[0.0], np.cumsum(values[:-1] * np.diff(times))])
    means: FloatArray = np.diff(np.interp(instants, times, integral)) / np.diff(instants)
    return means


def cubic(times: FloatArray, values: FloatArray, instants: FloatArray) -> FloatArray:
    """Return the values at instants of the cubics through the four samples around each.

    Parameters
    ----------
    times, values : ndarray, shape (n,)
        Samples, n at least 4; the times [s] increase.
    instants : ndarray, shape (m,)
        Within the times [s].

    Returns
    -------
    ndarray, shape (m,)
    """
    before = np.searchsorted(times, instants, side="right") - 1
    first = np.clip(before - 1, 0, times.size - NEIGHBORS)
    nodes = [times[first + n] for n in range(NEIGHBORS)]
    result = np.zeros(instants.size)
    for n, node in enumerate(nodes):
        weight = np.ones(instants.size)
        for other in nodes[:n] + nodes[n + 1 :]:
            weight *= (instants - other) / (node - other)
        result += weight * values[first + n]
    return result
