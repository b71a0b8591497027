"""Constants of a machine from its telemetry, beginning with values that may be far off.

The estimator's own fit is used with a prior so wide that it says nothing.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bdt_plant.friction import friction_voltage
from bdt_plant.plant import PlantModel
from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_study.calibration.fitted_data import SETTINGS, Data
from bdt_study.calibration.followed_windows import follow_windows
from bdt_study.calibration.gap_valley import best_of_valley
from bdt_study.calibration.machine_search import fit_from_any_gap, search_beginning
from bdt_study.calibration.motor_lag import without_early_reading
from bdt_study.calibration.prior_knowledge import (
    HELD_SPREAD,
    is_plausible,
    wide_knowledge,
)
from bdt_study.calibration.trial_search import trial_fit
from bdt_study.calibration.whole_fit import (
    FINE,
    fit_machine_noise,
    fit_reading_noise,
    fit_whole,
)
from bdt_study.calibration.yielding_search import compare_frictions
from bdt_twin.effect_trials import LATE_VOLTAGE, OTHER_TOP_MASS, THREAD_ERROR, EffectTrial
from bdt_twin.fit_result import Fit
from bdt_twin.gap_doubt import yielding_doubt
from bdt_twin.machine_knowledge import EFFECTS, THREAD_PARTS, MachineKnowledge
from bdt_twin.model_factors import FACTORS, model_with
from bdt_twin.output_error_fit import WindowFit
from bdt_twin.unknowns import Unknowns
from bdt_twin.window_search import initial_conditions_at_rest

FloatArray = NDArray[np.float64]

NO_GAP = math.radians(1.0)
"""Gap below which there may be none [rad]."""
HIDDEN_WALK = 2.0
"""Walks of the motor in a second behind which a gap can hide."""
UNEXPLAINED = 0.05
"""Share of the motion that a machine may leave."""
FAR = 0.5
"""Change of a factor's logarithm after which a fit begins again, about the model that it found."""
MOST_BEGINNINGS = 3
"""Largest number of such beginnings."""

TRIALS: tuple[tuple[tuple[str, ...], EffectTrial], ...] = (
    (("top_mass",), OTHER_TOP_MASS),
    (THREAD_PARTS, THREAD_ERROR),
)
"""Effects that a fit does not find that begins without any, and how they are tried."""
SEARCHES = ((("voltage_lag",), LATE_VOLTAGE), *TRIALS)
"""What all data are searched for where no window has found it, or no window can tell."""


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
    joined : tuple of str
        Effects beside ``CALIBRATED_EFFECTS`` that the fit was looking for.
    friction_doubt : float
        Standard uncertainty of a gap because friction that is thought to be rigid may yield, or
        the other way round [rad].
    """

    model: PlantModel
    window: CalibrationWindow
    fit: Fit
    joined: tuple[str, ...] = ()
    friction_doubt: float = 0.0

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
        hidden = yielding_doubt(self.fit, openness=0.0)
        return gap, math.hypot(uncertainty, hidden, self.friction_doubt)

    @property
    def explains(self) -> bool:
        """Whether the machine leaves so little of the motion that its constants mean something."""
        return self.fit.residual <= UNEXPLAINED * self.window.motion

    @property
    def found_model(self) -> PlantModel:
        """The mechanism that was found, without friction, which is among the effects."""
        return model_with(self.model, self.fit.unknowns.model_factors)

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
    start = search_beginning(model, data)
    moved = start.factors
    for _ in range(MOST_BEGINNINGS):
        # The fit goes on from a model whose factors are ones: its logarithms are bounded.
        # What a motor that answers too late takes for an early reading, no window believes.
        model, start = without_early_reading(model_with(model, start.factors), start)
        found = _identify_near(model, data, replace(start, factors=np.zeros(len(FACTORS))), -moved)
        start = found.fit.unknowns
        moved = moved + start.factors
        if np.abs(start.factors).max() < FAR:
            break
    return found


def _identify_near(
    model: PlantModel, data: Data, start: Unknowns, expected: FloatArray
) -> Identification:
    """Return the machine that explains the data best, near a model.

    Parameters
    ----------
    model : PlantModel
        The model.
    data : Data
        Telemetry.
    start : Unknowns
        What explains the data roughly.
    expected : ndarray, shape (3,)
        Logarithms of the factors by which the start values differ from the model.
    """
    followed = follow_windows(model, data)
    window = data.window(model, 0 if followed is None else followed.cogs)
    joined = () if followed is None else followed.joined
    known = _known(model, joined, expected)
    problem = WindowFit(window, SETTINGS.growth_change, known)
    for names, trial in TRIALS:
        if names[0] in joined and not start.effects[list(trial.places)].any():
            start = trial.begun(start)
    # Windows that are too short for the machine may have led astray.
    beginnings = [start] if followed is None else [start, followed.on(window)]
    fits = [fit_whole(problem, beginning) for beginning in beginnings]
    if any(fits[0].levels[1:]):
        # Where the model is wrong, least squares may have led astray, to no gap at all say.
        other = fit_from_any_gap(window, known, start, FINE)
        fits.append(fit_machine_noise(problem, other))
    likely = [each for each in fits if is_plausible(each, known)]
    fit = min(likely or fits, key=lambda each: each.prediction_error)
    for names, trial in SEARCHES:
        if names[0] not in joined:
            with_it = (*joined, *names)
            found = trial_fit(window, fit, _known(model, with_it, expected), trial)
            if found is not None:
                fit, joined = found, with_it
    doubt = 0.0
    if "yield_angle" not in joined:
        with_it = (*joined, "yield_angle")
        yielding, doubt = compare_frictions(window, fit, _known(model, with_it, expected))
        if yielding is not None:
            fit, joined = yielding, with_it
    fit = best_of_valley(window, fit, _known(model, joined, expected))
    return Identification(model, window, fit, joined, doubt)


def _known(model: PlantModel, joined: Collection[str], expected: FloatArray) -> MachineKnowledge:
    """Return what is known before, with logarithms of the factors that are expected."""
    known = wide_knowledge(friction_voltage(model.motor), joined)
    known.expected[: len(FACTORS)] = expected
    return known


def identify_from(known: Identification, data: Data) -> Identification:
    """Return the machine that explains other data, beginning with one that was found before.

    Parameters
    ----------
    known : Identification
        Where to begin; what it knows is no prior.
    data : Data
        Telemetry.
    """
    window = data.window(known.model, known.window.cogs)
    knowledge = wide_knowledge(known.effect("friction_voltage"), known.joined)
    problem = WindowFit(window, SETTINGS.growth_change, knowledge)
    fit = fit_whole(problem, _moved(known, window))
    return Identification(known.model, window, fit, known.joined)


def with_machine_held(known: Identification, data: Data) -> Identification:
    """Return the fit of other data in which the machine stays what it is.

    Parameters
    ----------
    known : Identification
        The machine.
    data : Data
        Telemetry; its initial conditions and the gap are fitted.
    """
    window, told = data.window(known.model, known.window.cogs), known.fit.machine
    held = MachineKnowledge(told.expected, np.diag(np.square(HELD_SPREAD)))
    problem = WindowFit(window, SETTINGS.growth_change, held)
    return Identification(
        known.model, window, fit_reading_noise(problem, _moved(known, window)), known.joined
    )


def _moved(known: Identification, window: CalibrationWindow) -> Unknowns:
    """Return the unknowns of a machine that was found, for another window."""
    unknowns = known.fit.unknowns
    gaps = np.interp(window.knots, known.window.knots, unknowns.gaps)
    return Unknowns(gaps, unknowns.factors, initial_conditions_at_rest(window), unknowns.effects)
