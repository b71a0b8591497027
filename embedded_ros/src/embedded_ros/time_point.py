"""Points in time, and the kinds of clocks on which they stand."""

from collections.abc import Callable
from enum import IntEnum
from typing import Any, overload

from embedded_ros.duration import NANOSECONDS_PER_SECOND, Duration, whole_nanoseconds
from embedded_ros.ordering import Ordered

__all__ = ["ClockType", "Time"]


class ClockType(IntEnum):
    """What a clock counts."""

    UNINITIALIZED = 0
    #: Simulated time if a time source provides it, else system time.
    ROS_TIME = 1
    SYSTEM_TIME = 2
    STEADY_TIME = 3


class Time(Ordered):
    """A point in time on a clock; times of different clock types do not compare.

    Parameters
    ----------
    seconds : int or float
    nanoseconds : int
        Added to `seconds`.
    clock_type : ClockType

    Raises
    ------
    ValueError
        If a number is negative.
    OverflowError
        If the sum does not fit into 63 bits.
    """

    __slots__ = ("_kind", "_since_epoch")

    def __init__(
        self,
        *,
        seconds: int | float = 0,
        nanoseconds: int = 0,
        clock_type: ClockType = ClockType.SYSTEM_TIME,
    ) -> None:
        if not isinstance(clock_type, ClockType):
            raise TypeError("Clock type must be a ClockType enum")
        for unit, number in (("Seconds", seconds), ("Nanoseconds", nanoseconds)):
            if number < 0:
                raise ValueError(f"{unit} value must not be negative")
        self._since_epoch = whole_nanoseconds(seconds, nanoseconds, "time point")
        self._kind = clock_type

    @property
    def nanoseconds(self) -> int:
        """Nanoseconds since the clock's epoch."""
        return self._since_epoch

    def seconds_nanoseconds(self) -> tuple[int, int]:
        """Whole seconds and the nanoseconds beyond them."""
        return divmod(self._since_epoch, NANOSECONDS_PER_SECOND)

    @property
    def clock_type(self) -> ClockType:
        """Type of the clock on which this time stands."""
        return self._kind

    def __repr__(self) -> str:
        return f"Time(nanoseconds={self._since_epoch}, clock_type={self._kind.name})"

    # ------------------------------------------------------------------ arithmetic

    def _moved(self, nanoseconds: int, error: type[Exception], complaint: str) -> "Time":
        """Time on the same clock; `error` replaces what its constructor raises of that type."""
        try:
            return Time(nanoseconds=self._since_epoch + nanoseconds, clock_type=self._kind)
        except error as cause:
            raise error(complaint) from cause

    def __add__(self, other: Duration) -> "Time":
        if isinstance(other, Duration):
            complaint = "Addition leads to overflow in C storage."
            return self._moved(other.nanoseconds, OverflowError, complaint)
        return NotImplemented

    __radd__ = __add__

    @overload
    def __sub__(self, other: "Time") -> Duration: ...
    @overload
    def __sub__(self, other: Duration) -> "Time": ...
    def __sub__(self, other: "Time | Duration") -> "Time | Duration":
        if isinstance(other, Duration):
            complaint = "Subtraction leads to negative time."
            return self._moved(-other.nanoseconds, ValueError, complaint)
        if isinstance(other, Time):
            start = other._on_same_clock(self, "subtract times")
            return Duration(nanoseconds=self._since_epoch - start)
        return NotImplemented

    # ------------------------------------------------------------------ comparison

    def _on_same_clock(self, other: "Time", doing: str) -> int:
        if self._kind is other._kind:
            return self._since_epoch
        raise TypeError(f"Can't {doing} with different clock types")

    def _compared(self, other: object, holds: Callable[[int, int], bool]) -> bool:
        if isinstance(other, Time):
            return holds(self._since_epoch, other._on_same_clock(self, "compare times"))
        return NotImplemented  # type: ignore[no-any-return]

    # ------------------------------------------------------------------ messages

    def to_msg(self) -> Any:
        """Convert to a ``builtin_interfaces.msg.Time``."""
        from builtin_interfaces.msg import Time as Message

        return Message(**dict(zip(("sec", "nanosec"), self.seconds_nanoseconds(), strict=True)))

    @classmethod
    def from_msg(cls, msg: Any, clock_type: ClockType = ClockType.ROS_TIME) -> "Time":
        """Convert from a ``builtin_interfaces.msg.Time``."""
        from builtin_interfaces.msg import Time as Message

        if isinstance(msg, Message):
            return cls(clock_type=clock_type, nanoseconds=msg.nanosec, seconds=msg.sec)
        raise TypeError("Must pass a builtin_interfaces.msg.Time object")
