"""Search for friction that yields before it slides, in all data at once."""

from dataclasses import replace

from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_study.calibration.fitted_data import SETTINGS
from bdt_study.calibration.whole_fit import fit_machine_noise
from bdt_twin.fit_result import Fit
from bdt_twin.friction_evidence import are_alike
from bdt_twin.machine_knowledge import YIELD_ANGLE, MachineKnowledge
from bdt_twin.machine_memory import SMALLEST_FRICTION
from bdt_twin.noise_levels import quiet
from bdt_twin.output_error_fit import WindowFit

FIRST_ANGLES = 2e-3, 1e-2
"""Yield angles at which fits begin [rad]."""
GAIN = 10.0
"""Gain of log-likelihood over rigid friction from which on friction is one that yields."""
ALIKE = 1.3
"""Ratio of the angles that the fits have found below which it is one angle."""


def yielding_fit(window: CalibrationWindow, rigid: Fit, known: MachineKnowledge) -> Fit | None:
    """Return the fit with friction that yields; None if rigid friction explains the data as well.

    Wherever it begins, a fit finds the same angle by which friction yields, if it does.

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
        return None
    problem = WindowFit(window, SETTINGS.growth_change, known)
    fits = []
    for angle in FIRST_ANGLES:
        unknowns = rigid.unknowns.with_yield_angle(angle)
        begun = replace(rigid, unknowns=unknowns, levels=quiet(rigid.levels))
        fits.append(fit_machine_noise(problem, fit_machine_noise(problem, begun)))
    angles = [float(each.unknowns.effects[YIELD_ANGLE]) for each in fits]
    if min(each.gain_over(rigid) for each in fits) < GAIN or not are_alike(angles, ALIKE):
        return None
    return min(fits, key=lambda each: each.prediction_error)
