"""Telemetry of a drive: a row for each sample, evenly spaced, with the voltage as applied."""

import numpy as np
from numpy.typing import NDArray

from bdt_driver.drive import Reading
from bdt_driver.hardware_clock import HardwareClock


class TelemetryRows:
    """Collects rows of time, voltage and position, in batches without holes.

    Where samples are missing another batch begins.
    """

    def __init__(self) -> None:
        self._batches: list[list[NDArray[np.float64]]] = []
        self._continues = False

    def __len__(self) -> int:
        return sum(len(rows) for batch in self._batches for rows in batch)

    def append(self, rows: NDArray[np.float64]) -> None:
        """Take rows, shape (n, 3), that follow those before by one sample time."""
        if not self._batches or not self._continues:
            self._batches.append([])
        self._batches[-1].append(rows)
        self._continues = True

    def leave_hole(self) -> None:
        """Note that samples are missing here."""
        self._continues = False

    def take(self) -> list[NDArray[np.float64]]:
        """Return the batches, each of shape (n, 3), and begin anew."""
        batches = [np.concatenate(batch) for batch in self._batches]
        self._batches.clear()
        return batches


class SampledWhenRead:
    """Rows of a drive that samples when it is read.

    The voltage that follows a reading is known with the next one: the newest row waits for it.

    Parameters
    ----------
    rows : TelemetryRows
        Gets the rows.

    Attributes
    ----------
    drift : float
        Relative difference of the sample time to the stated one: none.
    """

    def __init__(self, rows: TelemetryRows) -> None:
        self._rows = rows
        self._waiting: tuple[int, float, float] | None = None
        self.drift = 0.0

    def add(self, number: int, time: float, reading: Reading) -> float:
        """Take a reading.

        Parameters
        ----------
        number : int
            Number of its control period.
        time : float
            Its time [s].
        reading : Reading
            What the drive has measured.

        Returns
        -------
        float
            The time of the position [s].
        """
        waiting, self._waiting = self._waiting, (number, time, reading.position)
        if waiting is not None and waiting[0] == number - 1:
            self._rows.append(np.array([[waiting[1], reading.voltage, waiting[2]]]))
        else:
            self._rows.leave_hole()
        return time


class SampledByHardware:
    """Rows of a drive that samples by a clock of its own.

    Parameters
    ----------
    rows : TelemetryRows
        Gets the rows.
    rate : float
        Sampling rate as the hardware states it [Hz].
    """

    def __init__(self, rows: TelemetryRows, rate: float) -> None:
        self._rows = rows
        self._clock = HardwareClock(rate)

    @property
    def drift(self) -> float:
        """Relative difference of the sample time to the stated one, as found."""
        return self._clock.drift

    def add(self, _number: int, time: float, reading: Reading) -> float | None:
        """Take a reading; see :meth:`SampledWhenRead.add`.

        Returns
        -------
        float or None
            The time of the newest sample [s]; None when there is none yet.
        """
        samples = reading.samples
        if samples is None or not len(samples):
            return None
        restarts = self._clock.restarts
        times = self._clock.times(len(samples), reading.lost, time)
        if reading.lost or self._clock.restarts != restarts:
            self._rows.leave_hole()
        self._rows.append(np.column_stack((times, samples)))
        return float(times[-1])
