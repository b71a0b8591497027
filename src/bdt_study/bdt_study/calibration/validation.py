"""How well a machine found in one half of the data explains the other half."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_study.calibration.fitted_data import Data
from bdt_study.calibration.identification import (
    Identification,
    identify_from,
    with_machine_held,
)

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Residual:
    """What a simulation leaves of the measured position.

    Attributes
    ----------
    times : ndarray, shape (n,)
        Times of the samples [s].
    position, residual : ndarray, shape (n,)
        Measured position [m], and what the simulation leaves of it [m].
    """

    times: FloatArray
    position: FloatArray
    residual: FloatArray

    @property
    def rms(self) -> float:
        """Root mean square of the residual [m]."""
        return float(np.sqrt(np.mean(np.square(self.residual))))


def residual_of(data: Data, found: Identification) -> Residual:
    """Return what the simulation of a fit leaves of the data that it was fitted to."""
    times = [
        (stretch.first + np.arange(stretch.voltage.size)) / data.sampling_rate
        for stretch in data.stretches
    ]
    position = np.concatenate([stretch.position for stretch in data.stretches])
    simulated = np.concatenate([run.position for run in found.fit.responses])
    return Residual(np.concatenate(times), position, position - simulated)


def validate_machine(found: Identification, first: Data, second: Data) -> Residual:
    """Fit the machine to the first half alone and return what it leaves of the second.

    For the second half the machine is held. Its initial conditions and the gap are fitted, since
    these are none of its constants.

    Parameters
    ----------
    found : Identification
        Where the fit of the first half begins.
    first, second : Data
        The halves.
    """
    learned = identify_from(found, first)
    return residual_of(second, with_machine_held(learned, second))
