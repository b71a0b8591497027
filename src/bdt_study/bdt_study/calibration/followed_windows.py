"""The machine as the estimator finds it, one window of the data after the other.

A fit of all data at once ends in the wrong place if it lacks an effect of the machine: what
friction at rest does to a minute of slow motion, no gap and no offset explain. In a window of some
seconds less goes wrong, and the estimator adds the effects that windows give evidence of.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bdt_plant.plant import PlantModel
from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_study.calibration.fitted_data import Data
from bdt_study.calibration.prior_knowledge import CALIBRATED_EFFECTS, JOINING_EFFECTS
from bdt_twin.machine_knowledge import EFFECTS, VOLTAGE_LAG
from bdt_twin.output_error import OutputErrorEstimator
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.unknowns import Unknowns
from bdt_twin.window_search import initial_conditions_at_rest

FloatArray = NDArray[np.float64]

BATCH = 0.1
"""Length of the batches that the estimator gets [s]."""


@dataclass(frozen=True, eq=False)
class FollowedMachine:
    """What the windows have told.

    Attributes
    ----------
    factors, effects : ndarray
        ``FACTORS`` as logarithms, and ``EFFECTS``, of the newest window.
    times, gaps : ndarray, shape (windows,)
        Times [s] at which the gap was told, increasing, and the gap then [rad].
    joined : tuple of str
        Those of ``JOINING_EFFECTS`` of whose group the machine has one.
    cogs : int
        Periods of the motor's cogging in a turn; 0 for none.
    """

    factors: FloatArray
    effects: FloatArray
    times: FloatArray
    gaps: FloatArray
    joined: tuple[str, ...]
    cogs: int

    def on(self, window: CalibrationWindow) -> Unknowns:
        """Return where the fit of a window begins that follows this machine from rest."""
        gaps = np.interp(window.knots, self.times, self.gaps)
        beginning = initial_conditions_at_rest(window)
        return Unknowns(gaps, self.factors, beginning, self.effects)


def follow_windows(model: PlantModel, data: Data) -> FollowedMachine | None:
    """Return the machine that the estimator finds; None if no window tells it the gap.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism, as far as they are known.
    data : Data
        Telemetry.
    """
    estimator = OutputErrorEstimator(model, _settings_at(data.sampling_rate), data.sampling_rate)
    told: dict[float, float] = {}
    size = round(BATCH * data.sampling_rate)
    for stretch in data.stretches:
        for begin in range(0, stretch.voltage.size, size):
            voltage = stretch.voltage[begin : begin + size]
            position = stretch.position[begin : begin + size]
            stamps = (stretch.first + begin + np.arange(voltage.size)) / data.sampling_rate
            estimate = estimator.update(np.stack([stamps, voltage, position], axis=1))
            if estimate is not None and estimate.is_known and not estimate.reason:
                told[estimate.time] = estimate.gap
    last, kept = estimator.last_fit, estimator.recollection
    if last is None or kept is None:
        return None
    joined = tuple(
        name for group in JOINING_EFFECTS if not kept.present.isdisjoint(group) for name in group
    )
    effects = np.where(
        [name in (*CALIBRATED_EFFECTS, *joined, "voltage_lag") for name in EFFECTS],
        last.fit.unknowns.effects,
        0.0,
    )
    # All data have to tell a late voltage from a late reading: one window is easily wrong about it.
    effects[EFFECTS.index("delay")] += effects[VOLTAGE_LAG]
    effects[VOLTAGE_LAG] = 0.0
    times = np.array(sorted(told))
    gaps = np.array([told[time] for time in times.tolist()])
    return FollowedMachine(last.fit.unknowns.factors, effects, times, gaps, joined, kept.cogs)


def _settings_at(sampling_rate: float) -> OutputErrorSettings:
    """Return the estimator's settings, updated after whole samples: clocks of machines are off."""
    settings = OutputErrorSettings()
    samples = max(round(settings.update_period * sampling_rate), 1)
    return replace(settings, update_period=samples / sampling_rate)
