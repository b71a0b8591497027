"""When a plant in lockstep may go on: at a pace of the wall clock, and until a time to wait at."""

import math

LONGEST_LAG = 0.1
"""Wall time [s] behind its pace from which on a plant goes on from where it is, and makes up for
nothing."""


class Pace:
    """The pace of simulated time.

    Parameters
    ----------
    pace : float
        Simulated seconds in a second of wall time; 0 for as many as there can be.
    pause_at : float
        Simulated time [s] from which on the plant waits.
    """

    def __init__(self, pace: float = 0.0, pause_at: float = math.inf) -> None:
        self.configure(pace, pause_at)

    def configure(self, pace: float, pause_at: float) -> None:
        """Take another pace and another time to wait at, from now on."""
        self._pace, self._pause_at = pace, pause_at
        self._anchor: tuple[float, float] | None = None

    @property
    def is_free(self) -> bool:
        """Whether the wall clock does not matter."""
        return self._pace == 0.0

    def is_due(self, time: float, now: float) -> bool:
        """Tell whether the measurement of a time may be published.

        Parameters
        ----------
        time : float
            Simulated time of the measurement [s].
        now : float
            Wall time [s], of any origin.
        """
        if time >= self._pause_at:
            self._anchor = None
            return False
        if self.is_free:
            return True
        begin, begun = self._anchor or (time, now)
        if now - begun - (time - begin) / self._pace > LONGEST_LAG:
            begin, begun = time, now
        self._anchor = begin, begun
        return (time - begin) / self._pace <= now - begun
