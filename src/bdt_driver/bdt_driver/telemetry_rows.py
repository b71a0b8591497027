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
        self._runs: list[list[NDArray[np.float64]]] = []
        self._newest: int | None = None
        self._waiting: tuple[int, float, float] | None = None

    def __len__(self) -> int:
        return sum(len(rows) for run in self._runs for rows in run)

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
                row = np.array([[waiting[1], reading.voltage, waiting[2]]])
                self._append(row, waiting[0], waiting[0])
            return
        samples = np.asarray(reading.samples, dtype=float)
        expected = self._per_period * (number - waiting[0]) if waiting else len(samples)
        if samples.ndim != 2 or samples.shape[1] != 2 or len(samples) != expected:
            raise ValueError(
                f"samples of shape {samples.shape}: must be ({expected}, 2), "
                f"{self._per_period} for each control period"
            )
        times = time + self._sample_time * np.arange(1 - len(samples), 1)
        first = waiting[0] + 1 if waiting else number
        self._append(np.column_stack((times, samples)), first, number)

    def take(self) -> list[NDArray[np.float64]]:
        """Return the rows as batches and begin the next one.

        Returns
        -------
        list of ndarray, shape (n, 3)
            Even times within each: where control periods were missed another one begins.
        """
        runs = [np.concatenate(run) for run in self._runs]
        self._runs.clear()
        return runs

    def _append(self, rows: NDArray[np.float64], first: int, last: int) -> None:
        if not self._runs or self._newest != first - 1:
            self._runs.append([])
        self._runs[-1].append(rows)
        self._newest = last
