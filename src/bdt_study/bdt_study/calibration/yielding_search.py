"""Search for friction that yields before it slides, in all data at once."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_study.calibration.fitted_data import SETTINGS
from bdt_study.calibration.whole_fit import fit_machine_noise
from bdt_twin.fit_result import Fit
from bdt_twin.fixed_order import mean
from bdt_twin.friction_evidence import DIFFERENCE_DOUBT, are_alike
from bdt_twin.machine_knowledge import YIELD_ANGLE, MachineKnowledge
from bdt_twin.machine_memory import SMALLEST_FRICTION
from bdt_twin.noise_levels import quiet
from bdt_twin.output_error_fit import WindowFit

FIRST_ANGLES = 2e-3, 1e-2
"""Yield angles at which fits begin [rad]."""
GAIN = 10.0
"""Gain of log-likelihood over rigid friction from which on friction is one that yields; a fit that
loses as much, or gains twice as much more, leaves no doubt."""
ALIKE = 1.3
"""Ratio of the angles that the fits have found below which it is one angle."""


class FrictionComparison(NamedTuple):
    """What data tell of friction that yields, beside a rigid one.

    Attributes
    ----------
    yielding : Fit or None
        The fit with friction that yields; None if rigid friction explains the data as well.
    doubt : float
        Standard uncertainty of a gap because the other friction may be the true one [rad].
    """

    yielding: Fit | None
    doubt: float


def compare_frictions(
    window: CalibrationWindow, rigid: Fit, known: MachineKnowledge
) -> FrictionComparison:
    """Return what data tell of friction that yields.

    Wherever it begins, a fit finds the same angle by which friction yields, if it does. Where a
    motor always reverses alike, the data tell an angle from a wider gap hardly or not at all.

    Parameters
    ----------
    window : CalibrationWindow
        Model and data.
    rigid : Fit
        Their fit with rigid friction.
    known : MachineKnowledge
        What is known before of a machine whose friction yields.
    """
    if rigid.unknowns.friction < SMALLEST_FRICTION:
        return FrictionComparison(None, 0.0)
    problem = WindowFit(window, SETTINGS.growth_change, known)
    fits = []
    for angle in FIRST_ANGLES:
        unknowns = rigid.unknowns.with_yield_angle(angle)
        begun = replace(rigid, unknowns=unknowns, levels=quiet(rigid.levels))
        fits.append(fit_machine_noise(problem, fit_machine_noise(problem, begun)))
    angles = [float(each.unknowns.effects[YIELD_ANGLE]) for each in fits]
    best = min(fits, key=lambda each: each.prediction_error)
    gains = [each.gain_over(rigid) for each in fits]
    yields = min(gains) >= GAIN and are_alike(angles, ALIKE)
    against = 0.5 * (max(gains) - GAIN) if yields else -max(gains)
    openness = min(max(1.0 - against / GAIN, 0.0), 1.0)
    difference = mean(np.abs(best.unknowns.gaps - rigid.unknowns.gaps))
    return FrictionComparison(best if yields else None, DIFFERENCE_DOUBT * openness * difference)
