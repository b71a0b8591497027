"""Jumps of simulated time, and which of them a callback is for."""

from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from embedded_ros.duration import Duration

__all__ = ["ClockChange", "JumpThreshold", "TimeJump"]


class ClockChange(IntEnum):
    """What happened to the source of a clock's time."""

    ROS_TIME_NO_CHANGE = 1
    ROS_TIME_ACTIVATED = 2
    ROS_TIME_DEACTIVATED = 3
    SYSTEM_TIME_NO_CHANGE = 4


_SWITCHES: Final = (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED)


@dataclass(kw_only=True, eq=False)
class JumpThreshold:
    """Which jumps a callback is for.

    Parameters
    ----------
    min_forward : Duration or None
        Smallest jump forward, positive; None: none.
    min_backward : Duration or None
        Smallest jump backward, negative; None: none.
    on_clock_change : bool
        Whether activation and deactivation of simulated time count.
    """

    min_forward: Duration | None
    min_backward: Duration | None
    on_clock_change: bool = True

    def __post_init__(self) -> None:
        for name, bound, sign, meaning in (
            ("min_forward", self.min_forward, 1, "positive"),
            ("min_backward", self.min_backward, -1, "negative"),
        ):
            if bound is not None and sign * bound.nanoseconds <= 0:
                raise ValueError(f"{name} must be a {meaning} non-zero duration")
        if not (self.on_clock_change or self.min_forward or self.min_backward):
            raise ValueError("At least one jump threshold must be enabled")

    def is_met(self, change: ClockChange, delta: int) -> bool:
        """Tell whether a jump counts; `delta` in nanoseconds."""
        if change in _SWITCHES:
            return self.on_clock_change
        bound = self.min_forward if delta > 0 else self.min_backward
        return bound is not None and abs(delta) >= abs(bound.nanoseconds)


@dataclass(frozen=True, eq=False)
class TimeJump:
    """A jump that has happened.

    Parameters
    ----------
    clock_change : ClockChange
        What happened to the source of time.
    delta : Duration
        Time after the jump less the time before.
    """

    clock_change: ClockChange
    delta: Duration

    def __post_init__(self) -> None:
        if not isinstance(self.clock_change, ClockChange):
            raise TypeError("clock_change must be an instance of rclpy.clock.ClockChange")
