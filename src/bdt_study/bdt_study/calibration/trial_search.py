"""Search in all data at once for what windows may have missed, as the twin tries it in a window."""

from dataclasses import replace

from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_study.calibration.fitted_data import SETTINGS
from bdt_study.calibration.whole_fit import fit_machine_noise
from bdt_twin.effect_trials import EffectTrial
from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import MachineKnowledge
from bdt_twin.noise_levels import quiet
from bdt_twin.output_error_fit import WindowFit


def trial_fit(
    window: CalibrationWindow, fit: Fit, known: MachineKnowledge, trial: EffectTrial
) -> Fit | None:
    """Return the fit with an effect; None where the one without explains the data as well.

    Parameters
    ----------
    window : CalibrationWindow
        Model and data.
    fit : Fit
        Their fit without it.
    known : MachineKnowledge
        What is known before of a machine that may have it.
    trial : EffectTrial
        How it is tried.
    """
    if not trial.is_possible(fit.machine):
        return None
    problem = WindowFit(window, SETTINGS.growth_change, known)
    begun = replace(fit, unknowns=trial.begun(fit.unknowns), levels=quiet(fit.levels))
    found = fit_machine_noise(problem, begun)
    return fit_machine_noise(problem, found) if trial.is_believed(found, fit) else None
