"""Time as the checks see it."""

import time
from typing import Protocol


class SteadyClock(Protocol):
    """A clock that never jumps."""

    def now(self) -> float:
        """Return the time [s], of any origin."""

    def sleep_until(self, due: float) -> None:
        """Return at a time [s], or at once if it has passed."""


class ComputerClock:
    """The steady clock of this computer."""

    def now(self) -> float:
        """Return the time [s], of any origin."""
        return time.monotonic()

    def sleep_until(self, due: float) -> None:
        """Return at a time [s], or at once if it has passed."""
        time.sleep(max(due - time.monotonic(), 0.0))
