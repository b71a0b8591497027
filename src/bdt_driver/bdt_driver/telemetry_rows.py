"""Telemetry of a drive: a row for each sample, evenly spaced, with the voltage as applied."""

import numpy as np
from numpy.typing import NDArray

from bdt_driver.drive import Reading


class TelemetryRows:
    """Collects rows of time, voltage and position.

    The voltage that follows a reading is known with the next one only, so that of a drive that
    samples when it is read the newest row waits for it.

    Parameters
    ----------
    samples_per_period : int
        Samples of one control period.
    sample_time : float
        Time between two samples [s].
    """

    def __init__(self, samples_per_period: int, sample_time: float) -> None:
        self._per_period = samples_per_period
        self._sample_time = sample_time
        self._rows: list[NDArray[np.float64]] = []
        self._waiting: tuple[int, float, float] | None = None

    def __len__(self) -> int:
        return sum(len(rows) for rows in self._rows)

    def add(self, number: int, time: float, reading: Reading) -> None:
        """Take a reading.

        Parameters
        ----------
        number : int
            Number of its control period.
        time : float
            Its time [s].
        reading : Reading
            What the drive has measured.

        Raises
        ------
        ValueError
            If it brings another number of samples than its periods have.
        """
        waiting, self._waiting = self._waiting, (number, time, reading.position)
        if reading.samples is None:
            if waiting is not None and waiting[0] == number - 1:
                self._rows.append(np.array([[waiting[1], reading.voltage, waiting[2]]]))
            return
        samples = np.asarray(reading.samples, dtype=float)
        expected = self._per_period * (number - waiting[0]) if waiting else len(samples)
        if samples.ndim != 2 or samples.shape[1] != 2 or len(samples) != expected:
            raise ValueError(
                f"samples of shape {samples.shape}: must be ({expected}, 2), "
                f"{self._per_period} for each control period"
            )
        times = time + self._sample_time * np.arange(1 - len(samples), 1)
        self._rows.append(np.column_stack((times, samples)))

    def take(self) -> NDArray[np.float64]:
        """Return the rows, shape (n, 3), and begin the next batch."""
        rows = np.concatenate(self._rows)
        self._rows.clear()
        return rows
