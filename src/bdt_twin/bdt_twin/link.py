"""The slow link between the twin and the controller, in simulated time."""

import heapq
from typing import NamedTuple


class Reconfiguration(NamedTuple):
    """A dead-zone tolerance on its way to the controller.

    Attributes
    ----------
    due : int
        Time at which it arrives [ns].
    estimated : int
        Stamp of the estimate behind it [ns].
    tolerance : float
        Dead-zone tolerance epsilon_dz [m].
    """

    due: int
    estimated: int
    tolerance: float


class DelayedLink:
    """Delivers reconfigurations a fixed time after they were sent, none after a newer one.

    Parameters
    ----------
    delay : float
        Communication delay [s].
    """

    def __init__(self, delay: float) -> None:
        self._delay = round(delay * 1e9)
        self._pending: list[Reconfiguration] = []
        self._newest: int | None = None

    def send(self, now: int, estimated: int, tolerance: float) -> int:
        """Send a tolerance at the time `now` [ns] and return when it arrives [ns]."""
        due = now + self._delay
        heapq.heappush(self._pending, Reconfiguration(due, estimated, tolerance))
        return due

    def deliver(self, now: int) -> Reconfiguration | None:
        """Return the newest of what has arrived at `now` [ns] and forget the older ones.

        None when nothing newer has arrived than what was delivered before.
        """
        delivered = None
        while self._pending and self._pending[0].due <= now:
            arrived = heapq.heappop(self._pending)
            if self._newest is None or arrived.estimated > self._newest:
                delivered, self._newest = arrived, arrived.estimated
        return delivered

    def next_due(self) -> int | None:
        """Return when the next reconfiguration arrives [ns], or None."""
        return self._pending[0].due if self._pending else None

    def drop(self) -> None:
        """Forget everything that is on its way and what was delivered."""
        self._pending.clear()
        self._newest = None
