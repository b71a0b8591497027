"""Search for another mass of the top platform than the start values say, in all data at once."""

from dataclasses import replace

from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_study.calibration.fitted_data import SETTINGS
from bdt_study.calibration.whole_fit import fit_machine_noise
from bdt_twin.effect_trials import is_believed
from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import TOP_MASS, MachineKnowledge
from bdt_twin.noise_levels import quiet
from bdt_twin.output_error_fit import WindowFit


def top_mass_fit(window: CalibrationWindow, fit: Fit, known: MachineKnowledge) -> Fit | None:
    """Return the fit with another mass; None if the given one explains the data as well.

    Stiffness and mass that are wrong together leave one mode of the structure as it is, so windows
    may not have missed the other one.

    Parameters
    ----------
    window : CalibrationWindow
        Model and data.
    fit : Fit
        Their fit with the mass that is said.
    known : MachineKnowledge
        What is known before of a machine that may have another one.
    """
    problem = WindowFit(window, SETTINGS.growth_change, known)
    begun = replace(fit, unknowns=fit.unknowns.with_other_top_mass(), levels=quiet(fit.levels))
    found = fit_machine_noise(problem, fit_machine_noise(problem, begun))
    return found if is_believed(TOP_MASS, found, fit) else None
