"""A drive for the driver node that notes when it is read and when it gets its command."""

import time
from array import array
from pathlib import Path

import numpy as np

from bdt_plant.compiled_period import compiled_period_of
from bdt_plant.gap_profile import GapProfile
from bdt_plant.plant import PlantModel, Sampling
from bdt_plant.plant_simulator import PlantSimulator

GAP = 0.2
"""Gap of the mechanism [rad]."""


class TimedDrive:
    """The paper's mechanism, a control period further at each reading.

    Parameters
    ----------
    file : str
        Gets the times [ns] when it is closed: an array of shape (n, 2), one row for each reading
        that was answered, of the reading and of its command.
    control_rate : float
        Rate of the readings [Hz].
    """

    def __init__(self, file: str, control_rate: float) -> None:
        self._file = Path(file)
        model, profile = PlantModel(), GapProfile("constant", GAP)
        sampling = Sampling(control_rate=control_rate)
        period = compiled_period_of(model)
        self._simulator = PlantSimulator(model, profile, sampling, period=period)
        self._times = array("q")
        self._read_at = 0
        self._voltage = 0.0

    def open(self) -> None:
        """Be at rest, as it is."""

    def read(self) -> tuple[float, float]:
        """Return position [m] and the voltage [V] that has moved it there."""
        applied = self._voltage
        self._simulator.advance(applied)
        self._read_at = time.monotonic_ns()
        return self._simulator.position, applied

    def write(self, voltage: float) -> None:
        """Take a voltage [V], which answers the last reading."""
        self._times.extend((self._read_at, time.monotonic_ns()))
        self._voltage = voltage

    def stop(self) -> None:
        """Take the voltage away."""
        self._voltage = 0.0

    def close(self) -> None:
        """Write the times."""
        with self._file.open("wb") as file:
            np.save(file, np.array(self._times, dtype=np.int64).reshape(-1, 2))
