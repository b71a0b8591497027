"""Times of readings: numbers over a rate, whatever a timer does."""


class SampleClock:
    """Numbers readings by the steady time at which they are due.

    Parameters
    ----------
    rate : float
        Readings per second [Hz].

    Attributes
    ----------
    missed : int
        Number of readings whose time passed without one.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._origin: float | None = None
        self._newest = -1
        self.missed = 0

    def tick(self, now: float) -> int | None:
        """Return the number of the reading that is due, counted from 0.

        Parameters
        ----------
        now : float
            Steady time [s], of any origin.

        Returns
        -------
        int or None
            None when the nearest one has been made.
        """
        if self._origin is None:
            self._origin = now
        number = round((now - self._origin) * self._rate)
        if number <= self._newest:
            return None
        self.missed += number - self._newest - 1
        self._newest = number
        return number

    def nanoseconds(self, number: int) -> int:
        """Return the time of a reading since the first one [ns]."""
        return round(number * 1e9 / self._rate)
