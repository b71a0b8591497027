"""A minute of motion that shows what a mechanism is like: steps, slow reversals and rests."""

from bisect import bisect_right
from typing import NamedTuple

DURATION = 60.0
"""Time after which the reference is back where it began, and stays [s]."""


class Motion(NamedTuple):
    """A motion at constant speed to a new level, which is then held.

    Attributes
    ----------
    begin : float
        Time at which it begins [s].
    level : float
        Where it ends, as a share of the travel: 0 is where the reference begins, 1 the other end.
    duration : float
        Time that it takes [s]; 0 for a step, which is as fast as is allowed.
    """

    begin: float
    level: float
    duration: float = 0.0


PLAN = (
    Motion(0.0, 0.0),
    # Steps of all sizes in both directions ring the structure and cross the gap at full speed.
    Motion(2.0, 1.0),
    Motion(5.0, 0.5),
    Motion(7.5, 0.75),
    Motion(9.5, 0.65),
    Motion(11.5, 0.15),
    # To and fro at constant speeds: what does not change sign with the speed is an offset, what
    # does is friction, and how it changes with the speed tells its parts apart.
    Motion(14.0, 0.9, 6.0),
    Motion(21.0, 0.15, 6.0),
    Motion(28.0, 0.9, 2.5),
    Motion(30.5, 0.15, 2.5),
    Motion(34.0, 0.35, 4.0),
    Motion(39.0, 0.15, 4.0),
    # Reversals before anything has come to rest: the delay, and the gap without static friction.
    Motion(44.0, 0.35),
    Motion(44.5, 0.15),
    Motion(45.0, 0.35),
    Motion(45.5, 0.15),
    Motion(48.0, 0.4),
    Motion(50.0, 0.8),
    Motion(52.5, 0.0),
)
"""The motions; the last rest, where it all began, shows drift."""

_BEGINS = tuple(motion.begin for motion in PLAN)
_ENDS = (*_BEGINS[1:], DURATION)
_FROM = (0.0, *(motion.level for motion in PLAN[:-1]))


def level_at(time: float, travel_time: float) -> float:
    """Return the reference as a share of its travel, 0 to 1.

    Parameters
    ----------
    time : float
        Time since the beginning [s].
    travel_time : float
        Time that the whole travel takes at the largest speed [s].
    """
    number = max(bisect_right(_BEGINS, time) - 1, 0)
    motion, start = PLAN[number], _FROM[number]
    duration = _duration(number, travel_time)
    if time - motion.begin >= duration:
        return motion.level
    return start + (motion.level - start) * max(time - motion.begin, 0.0) / duration


def longest_travel_time() -> float:
    """Return the longest time for the whole travel [s] with which each motion ends in time."""
    return min(
        (end - motion.begin) / abs(motion.level - start)
        for motion, start, end in zip(PLAN, _FROM, _ENDS, strict=True)
        if motion.level != start
    )


def _duration(number: int, travel_time: float) -> float:
    """Return the time that a motion takes [s]."""
    motion = PLAN[number]
    return max(motion.duration, abs(motion.level - _FROM[number]) * travel_time)
