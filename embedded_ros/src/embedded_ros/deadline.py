"""How long something may still take."""

import time
from typing import Final

from embedded_ros.duration import NANOSECONDS_PER_SECOND

__all__ = ["FOREVER", "NEVER", "Deadline"]

#: Nanoseconds that Cyclone DDS takes for no limit.
FOREVER: Final = 2**63 - 1


class Deadline:
    """The end of a wait, from now on.

    Parameters
    ----------
    seconds : float or None
        None or negative: there is none.
    """

    __slots__ = ("_at",)

    def __init__(self, seconds: float | None) -> None:
        self._at: int | None = None
        if seconds is not None and seconds >= 0:
            self._at = time.monotonic_ns() + int(float(seconds) * NANOSECONDS_PER_SECOND)

    def nanoseconds_left(self) -> int:
        """Nanoseconds until the end, not less than zero; :data:`FOREVER` if there is none."""
        if self._at is None:
            return FOREVER
        return min(max(0, self._at - time.monotonic_ns()), FOREVER)

    def seconds_left(self) -> float | None:
        """Seconds until the end, not less than zero; None if there is none."""
        return None if self._at is None else self.nanoseconds_left() / NANOSECONDS_PER_SECOND

    def is_over(self) -> bool:
        """Tell whether the end has come."""
        return self._at is not None and time.monotonic_ns() >= self._at


#: The deadline that never comes.
NEVER: Final = Deadline(None)
