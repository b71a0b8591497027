"""Constants of a machine from its telemetry, beginning with values that may be far off.

The estimator's own fit is used with a prior so wide that it says nothing.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from bdt_plant.friction import friction_voltage
from bdt_plant.plant import PlantModel
from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_study.calibration.fitted_data import SETTINGS, Data
from bdt_study.calibration.machine_search import fit_from_any_gap, search_beginning
from bdt_study.calibration.prior_knowledge import (
    HELD_SPREAD,
    is_plausible,
    wide_knowledge,
)
from bdt_study.calibration.segment_covariance import segment_covariance
from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import EFFECTS, MachineKnowledge
from bdt_twin.model_factors import FACTORS, model_with
from bdt_twin.output_error_fit import WindowFit
from bdt_twin.unknowns import Unknowns
from bdt_twin.window_search import initial_conditions_at_rest

NO_GAP = math.radians(1.0)
"""Gap below which there may be none [rad]."""
HIDDEN_WALK = 2.0
"""Walks of the motor in a second behind which a gap can hide."""
ROUGH, FINE = 8, 12
"""Largest numbers of steps of the fit to all samples, before and after noise is told apart."""
MOST_REPEATS = 8
"""Largest number of times that the fit before is begun anew, from where it ended."""
SETTLED = 0.98
"""Ratio of two residuals above which it has come to an end."""


@dataclass(frozen=True, eq=False)
class Identification:
    """A machine that was found.

    Attributes
    ----------
    model : PlantModel
        Constants of the mechanism with which the fit began; its factors correct them.
    window : WindowModel
        Model and data.
    fit : Fit
        The fit.
    """

    model: PlantModel
    window: CalibrationWindow
    fit: Fit

    def gap_at(self, time: float) -> tuple[float, float]:
        """Return the gap at a time [s] and its standard uncertainty [rad]."""
        weights = self.window.weights(np.array([time]))[:, 0]
        gap = float(weights @ self.fit.unknowns.gaps)
        uncertainty = math.sqrt(float(weights @ self.fit.gap_covariance @ weights))
        if gap < NO_GAP:
            # Noise of the machine at reversals can hide a gap, and no gap can be negative.
            walk = max(self.fit.levels.fast, self.fit.levels.slow)
            hidden = HIDDEN_WALK * walk / self.model.lead_screw.pitch
            uncertainty = math.hypot(uncertainty, hidden)
        return gap, uncertainty

    @property
    def found_model(self) -> PlantModel:
        """The mechanism that was found, without friction, which is among the effects."""
        return model_with(self.model, self.fit.unknowns.factors)

    def effect(self, name: str) -> float:
        """Return one of ``EFFECTS``."""
        return float(self.fit.unknowns.effects[EFFECTS.index(name)])


def identify(model: PlantModel, data: Data) -> Identification:
    """Return the machine that explains the data best.

    Parameters
    ----------
    model : PlantModel
        Start values, each off by up to a factor of two.
    data : Data
        Telemetry.

    Raises
    ------
    ValueError
        If no such machine explains the data even roughly.
    """
    found = search_beginning(model, data)
    # The fit goes on from a model whose factors are ones: its logarithms are bounded.
    begun = model_with(model, found.factors)
    knowledge = wide_knowledge(friction_voltage(model.motor))
    knowledge.expected[: len(FACTORS)] = -found.factors
    window = data.window(begun)
    problem = WindowFit(window, SETTINGS.growth_change, knowledge)
    start = replace(found, factors=np.zeros(len(FACTORS)))
    fit = _fitted(problem, start)
    if fit.levels[1:] != (0.0, 0.0, 0.0):
        # Where the model is wrong, least squares may have led astray, to no gap at all say.
        other = fit_from_any_gap(window, knowledge, start, FINE)
        other = problem.solve(other.unknowns, FINE, 3 * FINE, levels=other.levels)
        likely = [each for each in (fit, other) if is_plausible(each, knowledge)]
        fit = min(likely or [fit], key=lambda each: each.prediction_error)
    return Identification(begun, window, replace(fit, covariance=segment_covariance(window, fit)))


def identify_from(known: Identification, data: Data) -> Identification:
    """Return the machine that explains other data, beginning with one that was found before.

    Parameters
    ----------
    known : Identification
        Where to begin; what it knows is no prior.
    data : Data
        Telemetry.
    """
    window = data.window(known.model)
    knowledge = wide_knowledge(known.effect("friction_voltage"))
    problem = WindowFit(window, SETTINGS.growth_change, knowledge)
    return Identification(known.model, window, _fitted(problem, _moved(known, window)))


def with_machine_held(known: Identification, data: Data) -> Identification:
    """Return the fit of other data in which the machine stays what it is.

    Parameters
    ----------
    known : Identification
        The machine.
    data : Data
        Telemetry; its initial conditions and the gap are fitted.
    """
    window, told = data.window(known.model), known.fit.machine
    held = MachineKnowledge(told.expected, np.diag(np.square(HELD_SPREAD)))
    problem = WindowFit(window, SETTINGS.growth_change, held)
    return Identification(known.model, window, _rough(problem, _moved(known, window)))


def _fitted(problem: WindowFit, start: Unknowns) -> Fit:
    """Return the fit that begins near the machine.

    Noise of the machine is told from noise of the reading at the end only: as long as the model is
    wrong, any deviation would be taken for the machine's, and the fit would stay where it is.
    """
    near = _rough(problem, start)
    fit = problem.solve(near.unknowns, FINE, 3 * FINE, levels=near.levels)
    return problem.solve(fit.unknowns, FINE, 3 * FINE, levels=fit.levels)


def _rough(problem: WindowFit, start: Unknowns) -> Fit:
    """Return the fit for which all that is not explained is noise of the reading."""
    near = problem.solve(start, ROUGH, 3 * ROUGH)
    for _ in range(MOST_REPEATS):
        before = near.residual
        near = problem.solve(near.unknowns, ROUGH, 3 * ROUGH)
        if near.residual > SETTLED * before:
            break
    return near


def _moved(known: Identification, window: CalibrationWindow) -> Unknowns:
    """Return the unknowns of a machine that was found, for another window."""
    unknowns = known.fit.unknowns
    gaps = np.interp(window.knots, known.window.knots, unknowns.gaps)
    return Unknowns(gaps, unknowns.factors, initial_conditions_at_rest(window), unknowns.effects)
