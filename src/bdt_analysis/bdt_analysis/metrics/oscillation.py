"""Tells a limit cycle from ringing that dies out, from creep and from a single slip."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SMOOTHING_TIME = 0.02
"""Length [s] of the means on which oscillations are judged: noise is not an oscillation."""

COUNTED_SWING = 0.4
"""Part of the largest swing from which on another swing counts."""

SWINGS = 3
"""Number of counted swings in a window without which nothing oscillates: up, down, up."""

DECAY = 2.0 / 3.0
"""Peak to peak of the second half of the window over that of the first, below which the motion
decays. Ringing of the structure (27 rad/s, damping 5 %) has 0.13 over halves of 1.5 s."""

FASTEST_GROWTH = 4.0
"""Ratio of a swing to the one before above which this is an event and not a growth."""


class Oscillation(NamedTuple):
    """Oscillation in a window.

    Attributes
    ----------
    amplitude : float
        Size of the largest swing that is matched by one in the other direction, peak to peak
        [unit of the signal]; zero for a monotone motion, however large.
    sustained : bool
        True when it does not decay and fills the window.
    frequency : float or None
        Counted swings per time, two of them a period [Hz]; None if it is not sustained, or has
        fewer than three. The time runs from the middle of the first counted swing to that of the
        last one, which a drift moves less than turning points.
    """

    amplitude: float
    sustained: bool
    frequency: float | None = None


def find_oscillation(signal: FloatArray, sample_time: float) -> Oscillation:
    """Judge the oscillation in a window of a signal.

    A swing is the motion from one turning point to the next. It does not matter whether the
    signal drifts at the same time. An oscillation is sustained when all of these hold:

    - there are at least three swings of at least 40 % of the largest one (two cannot tell an
      oscillation from a slip out and back);
    - the second half of the window has at least 2/3 of the peak to peak of the first;
    - the swings fill the window: neither before the first nor after the last one is it quiet for
      more than twice the longest time between two of them. Swings that grow may begin later.

    When the first half has less than 40 % of the largest swing, something grows quickly or
    something happened late: it is sustained when at least three swings grow gradually to the end.

    Oscillations with a period of up to 2/3 of the window are found.

    Parameters
    ----------
    signal : ndarray, shape (n,)
        Signal at a constant sampling rate.
    sample_time : float
        Sample time [s].
    """
    block = max(round(SMOOTHING_TIME / sample_time), 1)
    smooth = _block_means(signal, block)
    if smooth.size < 4:
        return Oscillation(0.0, sustained=False)
    rise = np.max(smooth - np.minimum.accumulate(smooth))
    fall = np.max(np.maximum.accumulate(smooth) - smooth)
    amplitude = float(min(rise, fall))
    half = smooth.size // 2
    first, second = float(np.ptp(smooth[:half])), float(np.ptp(smooth[half:]))
    if amplitude <= 0.0 or second < DECAY * first:
        return Oscillation(amplitude, sustained=False)
    turns = turning_points(smooth, COUNTED_SWING * amplitude)
    middles = _middles(smooth, turns)
    if first < COUNTED_SWING * amplitude:
        sustained = _grows(smooth, COUNTED_SWING * first)
    else:
        sustained = _steady(smooth, turns, middles)
    if not sustained or len(middles) < SWINGS:
        return Oscillation(amplitude, sustained)
    time = (middles[-1] - middles[0]) * block * sample_time
    return Oscillation(amplitude, sustained, (len(middles) - 1) / (2.0 * time))


def turning_points(signal: FloatArray, threshold: float) -> list[int]:
    """Return where a signal turns, beginning and end of the first and last swing included.

    Parameters
    ----------
    signal : ndarray, shape (n,)
        Signal.
    threshold : float
        Motion against the direction of a swing that ends it, in the unit of the signal; positive.

    Returns
    -------
    list of int
        Increasing indices; between two of them lies one swing of at least `threshold`.
    """
    values = signal.tolist()
    turns: list[int] = []
    high = low = direction = 0
    highest = lowest = values[0] if values else 0.0
    for index, value in enumerate(values):
        if value > highest:
            highest, high = value, index
        if value < lowest:
            lowest, low = value, index
        if direction >= 0 and highest - value >= threshold:
            turns.append(high)
            direction, lowest, low = -1, value, index
        elif direction <= 0 and value - lowest >= threshold:
            turns.append(low)
            direction, highest, high = 1, value, index
    if direction:
        turns.append(high if direction > 0 else low)
    return turns


def _steady(smooth: FloatArray, turns: list[int], middles: list[int]) -> bool:
    """Tell whether there are three counted swings or more that reach from end to end."""
    if len(middles) < SWINGS:
        return False
    allowed = 2 * int(np.max(np.diff(middles)))
    # The first and the last swing are cut by the window: compare whole ones, if there are two.
    sizes = np.abs(np.diff(smooth[turns]))
    whole = sizes[1:-1] if sizes.size >= 4 else sizes
    begins = middles[0] <= allowed or bool(whole[-1] > whole[0])
    return begins and smooth.size - 1 - middles[-1] <= allowed


def _middles(smooth: FloatArray, turns: list[int]) -> list[int]:
    """Return where each swing is half done: before a slip it is quiet at the turning point."""
    values = smooth.tolist()
    return [_middle(values, first, last) for first, last in pairwise(turns)]


def _middle(values: list[float], first: int, last: int) -> int:
    """Return the first sample from a turning point on at which half of the swing is done."""
    begin, end = values[first], values[last]
    done = ((value - begin) / (end - begin) for value in values[first : last + 1])
    return next((index for index, part in enumerate(done, first) if part >= 0.5), first)


def _grows(smooth: FloatArray, threshold: float) -> bool:
    """Tell whether many swings grow gradually up to the end of the window."""
    if threshold <= 0.0:
        return False
    turns = turning_points(smooth, threshold)
    if len(turns) - 1 < SWINGS:
        return False
    sizes = np.abs(np.diff(smooth[turns]))
    gradual = bool((sizes[1:] <= FASTEST_GROWTH * sizes[:-1]).all())
    return gradual and int(sizes.argmax()) >= sizes.size - 2


def _block_means(signal: FloatArray, block: int) -> FloatArray:
    whole = signal.size // block * block
    means: FloatArray = signal[:whole].reshape(-1, block).mean(axis=1)
    return means
