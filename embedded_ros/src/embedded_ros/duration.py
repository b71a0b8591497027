"""Lengths of time: whole nanoseconds in 64 bits with a sign."""

from collections.abc import Callable
from typing import Any, Final

from embedded_ros.ordering import Ordered

__all__ = ["NANOSECONDS_PER_SECOND", "Duration", "Infinite", "whole_nanoseconds"]

NANOSECONDS_PER_SECOND: Final = 10**9
_LIMIT: Final = 2**63


def whole_nanoseconds(seconds: float, nanoseconds: int, container: str) -> int:
    """Sum of seconds and nanoseconds, cut to whole nanoseconds.

    Raises
    ------
    OverflowError
        If 64 bits do not hold it; `container` says what of.
    """
    count = int(seconds * NANOSECONDS_PER_SECOND) + int(nanoseconds)
    if -_LIMIT <= count < _LIMIT:
        return count
    raise OverflowError(f"Total nanoseconds value is too large to store in C {container}.")


class Duration(Ordered):
    """A period between two time points, in nanoseconds; it may be negative.

    Parameters
    ----------
    seconds : int or float
    nanoseconds : int
        Added to `seconds`.
    """

    __slots__ = ("_length",)

    def __init__(self, *, seconds: int | float = 0, nanoseconds: int = 0) -> None:
        self._length = whole_nanoseconds(seconds, nanoseconds, "duration")

    @property
    def nanoseconds(self) -> int:
        """Length in nanoseconds."""
        return self._length

    def __repr__(self) -> str:
        return f"Duration(nanoseconds={self._length})"

    def __str__(self) -> str:
        return "Infinite" if self == Infinite else f"{self._length} nanoseconds"

    def _compared(self, other: object, holds: Callable[[int, int], bool]) -> bool:
        return holds(self._length, other._length) if isinstance(other, Duration) else NotImplemented

    def to_msg(self) -> Any:
        """Convert to a ``builtin_interfaces.msg.Duration``."""
        from builtin_interfaces.msg import Duration as Message

        whole, rest = divmod(self._length, NANOSECONDS_PER_SECOND)
        return Message(sec=whole, nanosec=rest)

    @classmethod
    def from_msg(cls, msg: Any) -> "Duration":
        """Convert from a ``builtin_interfaces.msg.Duration``."""
        from builtin_interfaces.msg import Duration as Message

        if isinstance(msg, Message):
            return cls(seconds=msg.sec, nanoseconds=msg.nanosec)
        raise TypeError("Must pass a builtin_interfaces.msg.Duration object")


#: The largest duration that a QoS policy can hold: no limit.
Infinite: Final = Duration(seconds=9223372036, nanoseconds=854775807)
