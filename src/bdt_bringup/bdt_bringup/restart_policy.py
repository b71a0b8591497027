"""How often a node that died is started anew, and after which time."""

from collections import deque

MOST_RESTARTS = 5
"""Restarts of a node within ``PERIOD``; a node that dies once more then is given up."""
PERIOD = 60.0
"""Wall time [s] in which restarts are counted."""
FIRST_DELAY = 0.25
"""Wall time [s] before the first restart; it doubles with each one within ``PERIOD``."""


class RestartPolicy:
    """Remembers when a node has died."""

    def __init__(self) -> None:
        self._deaths: deque[float] = deque()

    def died(self, now: float) -> float | None:
        """Note a death and return what to do.

        Parameters
        ----------
        now : float
            Wall time [s], of any origin.

        Returns
        -------
        float or None
            Time to wait before the node is started anew [s]; None to give it up.
        """
        while self._deaths and now - self._deaths[0] >= PERIOD:
            self._deaths.popleft()
        if len(self._deaths) >= MOST_RESTARTS:
            return None
        self._deaths.append(now)
        return float(FIRST_DELAY * 2.0 ** (len(self._deaths) - 1))
