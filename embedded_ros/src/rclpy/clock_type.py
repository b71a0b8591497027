"""Kinds of clocks."""

from enum import IntEnum


class ClockType(IntEnum):
    """What a clock counts."""

    UNINITIALIZED = 0
    #: Simulated time if a time source provides it, else system time.
    ROS_TIME = 1
    SYSTEM_TIME = 2
    STEADY_TIME = 3
