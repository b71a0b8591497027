"""Telemetry to which a machine is fitted, and with which settings of the estimator."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bdt_plant.plant import PlantModel
from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.stretch import Stretch

SETTINGS = OutputErrorSettings(knot_spacing=5.0)
"""Those of the estimator, with a gap that grows evenly for longer."""


class Data(NamedTuple):
    """Telemetry that is fitted.

    Attributes
    ----------
    stretches : sequence of Stretch
        Telemetry without holes.
    sampling_rate : float
        Sampling rate [Hz].
    """

    stretches: Sequence[Stretch]
    sampling_rate: float

    @property
    def block(self) -> int:
        """Samples over which the residual is averaged."""
        return SETTINGS.samples_per_block(self.sampling_rate)

    def window(self, model: PlantModel, cogs: int = 0) -> CalibrationWindow:
        """Return the forward model of these data.

        Parameters
        ----------
        model : PlantModel
            The mechanism.
        cogs : int
            Periods of the motor's cogging in a turn; 0 for none.
        """
        first, last = self.stretches[0], self.stretches[-1]
        spacing = SETTINGS.knot_spacing
        begin = math.floor(first.first / self.sampling_rate / spacing)
        end = (last.first + last.voltage.size) / self.sampling_rate
        count = max(math.ceil(end / spacing) - begin, 1) + 1
        knots = spacing * (begin + np.arange(count, dtype=np.float64))
        return CalibrationWindow(
            model, list(self.stretches), knots, self.sampling_rate, self.block, cogs
        )
