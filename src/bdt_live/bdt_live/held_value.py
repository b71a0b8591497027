"""A value that holds from a time on until it is said anew."""

import math
from bisect import bisect_right


class HeldValue:
    """What was said of a value, and from when on; None before anything was said."""

    def __init__(self) -> None:
        self._times: list[float] = []
        self._values: list[float | None] = []
        self._latest: float | None = None

    def say(self, time: float, value: float | None) -> None:
        """Take what holds from a time on [s], in whatever order this is heard."""
        self._latest = value
        place = bisect_right(self._times, time)
        if place and self._values[place - 1] == value:
            return
        self._times.insert(place, time)
        self._values.insert(place, value)

    def at(self, time: float) -> float | None:
        """Return what holds at a time [s], and forget what held before: time goes on."""
        known = bisect_right(self._times, time)
        if not known:
            return None
        del self._times[: known - 1], self._values[: known - 1]
        return self._values[0]

    def restart(self) -> None:
        """Let what was said last hold from now on: time begins anew."""
        self._times, self._values = [-math.inf], [self._latest]
