"""Rate and latency of a loop, from when its messages were sent."""

from collections import deque
from statistics import median

SECOND = 1_000_000_000
WINDOW = 100
"""Latencies of which the median is taken, and measurements whose commands are awaited."""


class LoopTiming:
    """Counts commands, and matches them with the measurements that they answer.

    Parameters
    ----------
    window : int
        Latencies of which the median is taken.
    """

    def __init__(self, window: int = WINDOW) -> None:
        self._asked: dict[int, int] = {}
        self._latencies: deque[int] = deque(maxlen=window)
        self._count, self._begin, self._newest = 0, 0, 0
        self._rate: float | None = None

    def count(self, messages: int, newest: int, now: int) -> None:
        """Count commands.

        Parameters
        ----------
        messages : int
            How many have come since the last time.
        newest, now : int
            Wall times [ns] at which the newest one was sent, and of now.
        """
        self._count += messages
        if messages:
            self._newest = newest
        elapsed = self._newest - self._begin
        if elapsed >= SECOND:
            self._rate = self._count * SECOND / elapsed if self._begin else None
            self._count, self._begin = 0, self._newest
        elif now - self._newest > 2 * SECOND and self._begin:
            self._rate = 0.0

    def measured(self, stamp: int, sent: int) -> None:
        """Note when the measurement of a stamp [ns] was sent [ns of wall time]."""
        while len(self._asked) >= WINDOW:
            del self._asked[next(iter(self._asked))]
        self._asked[stamp] = sent

    def commanded(self, stamp: int, sent: int) -> None:
        """Note when the command that answers a stamp [ns] was sent [ns of wall time]."""
        asked = self._asked.pop(stamp, None)
        if asked is not None:
            self._latencies.append(sent - asked)

    @property
    def rate(self) -> float | None:
        """Commands in a second of wall time [Hz]; None before they were counted."""
        return self._rate

    @property
    def latency(self) -> float | None:
        """Median time from a measurement to its command [s]; None while there is none."""
        return median(self._latencies) * 1e-9 if self._latencies else None
