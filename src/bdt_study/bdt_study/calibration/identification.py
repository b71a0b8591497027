"""Constants of a machine from its telemetry, beginning with values that may be far off.

The estimator's own fit is used with a prior so wide that it says nothing. What a least-squares fit
does not find by itself is a structure that rings at half the frequency, or friction and a gap of
another size: these are tried on a coarse copy of the data, the unlikely ones only for a few steps.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.friction import friction_voltage
from bdt_plant.plant import PlantModel
from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_study.calibration.segment_covariance import segment_covariance
from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import EFFECTS, MachineKnowledge, independent_knowledge
from bdt_twin.model_factors import FACTORS, model_with
from bdt_twin.noise_levels import SMALLEST_NOISE
from bdt_twin.output_error_fit import WindowFit
from bdt_twin.output_error_settings import OutputErrorSettings
from bdt_twin.unknowns import Unknowns
from bdt_twin.window_model import Stretch
from bdt_twin.window_search import (
    COARSE_BLOCK_RATE,
    COARSE_RATE,
    initial_conditions_at_rest,
)

FloatArray = NDArray[np.float64]

FACTOR_SPREAD = (0.7, 0.7, 0.7)
"""Prior standard deviations of the logarithms of ``FACTORS``: twice as large, or half."""
EFFECT_SPREAD = (1.0, 0.2, 2e-3, 1e-5)
"""Prior standard deviations of ``EFFECTS`` [V, V, s, m/s]."""
HELD_SPREAD = (1e-7, 1e-7, 1e-7, 1e-7, 1e-7, 1e-9, 1e-12)
"""Standard deviations of ``FACTORS`` and ``EFFECTS`` that stay what they are."""

FIRST_GAPS = (2.0, 8.0, 20.0)
"""Gaps from which the search begins [deg]."""
FIRST_STIFFNESSES = (0.5, 0.7, 1.0, 1.4, 2.0)
"""Factors on k/m from which it begins: ringing is found again within a fifth of its frequency."""
FIRST_FRICTIONS = (0.0, 0.2)
"""Voltages for the friction, beside the known one, from which it begins [V]."""
ROUGH_MISFIT = 0.25
"""Share of the motion that the best beginning may leave."""
OTHER_GAPS = (3.0, 8.0, 16.0, 28.0)
"""Gaps from which it begins again if noise of the machine is found [deg]."""
NO_GAP = math.radians(1.0)
"""Gap below which there may be none [rad]."""
HIDDEN_WALK = 2.0
"""Walks of the motor in a second behind which a gap can hide."""
PLAUSIBLE = 4.0
"""Standard deviations of the prior within which a machine is one."""
UNTOLD = 1e-9
"""Standard deviation of an effect that is not looked for yet."""
SURVIVORS = (12, 4, 2)
"""How many beginnings are left after each round of the search."""
ROUNDS = (2, 4, 8)
"""Steps of the fit in each round."""
ROUGH, FINE = 8, 12
"""Largest numbers of steps of the fit to all samples, before and after noise is told apart."""
MOST_REPEATS = 8
"""Largest number of times that the fit before is begun anew, from where it ended."""
SETTLED = 0.98
"""Ratio of two residuals above which it has come to an end."""
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

    def window(self, model: PlantModel) -> CalibrationWindow:
        """Return the forward model of these data."""
        first, last = self.stretches[0], self.stretches[-1]
        spacing = SETTINGS.knot_spacing
        begin = math.floor(first.first / self.sampling_rate / spacing)
        end = (last.first + last.voltage.size) / self.sampling_rate
        count = max(math.ceil(end / spacing) - begin, 1) + 1
        knots = spacing * (begin + np.arange(count, dtype=np.float64))
        return CalibrationWindow(model, list(self.stretches), knots, self.sampling_rate, self.block)


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


def wide_knowledge(friction: float) -> MachineKnowledge:
    """Return a prior that hardly says more than the order of magnitude.

    Parameters
    ----------
    friction : float
        Expected voltage of the friction [V].
    """
    return independent_knowledge(friction, (*FACTOR_SPREAD, *EFFECT_SPREAD))


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
    found = _search(model, data)
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
        other = _with_any_gap(window, knowledge, start)
        other = problem.solve(other.unknowns, FINE, 3 * FINE, levels=other.levels)
        likely = [each for each in (fit, other) if _is_plausible(each, knowledge)]
        fit = min(likely or [fit], key=lambda each: each.prediction_error)
    return Identification(begun, window, replace(fit, covariance=segment_covariance(window, fit)))


def _is_plausible(fit: Fit, knowledge: MachineKnowledge) -> bool:
    """Tell whether a machine is what the prior allows, and not all of it noise of the machine."""
    off = np.abs(fit.machine.expected - knowledge.expected)
    spread = np.sqrt(np.diag(knowledge.covariance))
    return bool((off <= PLAUSIBLE * spread).all()) and fit.levels.reading > 2.0 * SMALLEST_NOISE


def _without_late_readings(knowledge: MachineKnowledge) -> MachineKnowledge:
    """Return a prior that holds delay and drift: at reversals a gap is like a late reading."""
    spread = np.diag(knowledge.covariance).copy()
    spread[[len(FACTORS) + EFFECTS.index(name) for name in ("delay", "drift")]] = UNTOLD**2
    return knowledge._replace(covariance=np.diag(spread))


def _with_any_gap(window: CalibrationWindow, knowledge: MachineKnowledge, start: Unknowns) -> Fit:
    """Return the best fit of a coarse copy that allows for noise of the machine all along."""
    coarse = window.coarse(COARSE_RATE, COARSE_BLOCK_RATE)
    problem = WindowFit(coarse, SETTINGS.growth_change, _without_late_readings(knowledge))
    beginning = initial_conditions_at_rest(coarse)
    effects = start.effects.copy()
    effects[[EFFECTS.index("delay"), EFFECTS.index("drift")]] = 0.0
    start, fits = replace(start, effects=effects), []
    for gap in OTHER_GAPS:
        gaps = np.full(coarse.knots.size, math.radians(gap))
        unknowns = replace(start, gaps=gaps, initial_conditions=beginning)
        levels = problem.solve(unknowns, 0, 1).levels
        fits.append(problem.solve(unknowns, FINE, 3 * FINE, levels=levels))
    return min(fits, key=lambda each: each.prediction_error)


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


def _search(model: PlantModel, data: Data) -> Unknowns:
    """Return the most likely of many beginnings, on a coarse copy of the data."""
    coarse = data.window(model).coarse(COARSE_RATE, COARSE_BLOCK_RATE)
    friction = friction_voltage(model.motor)
    knowledge = wide_knowledge(friction)
    frictions = dict.fromkeys((friction, *FIRST_FRICTIONS))
    candidates = []
    for gap, stiffness, voltage in product(FIRST_GAPS, FIRST_STIFFNESSES, frictions):
        factors, effects = np.zeros(len(FACTORS)), np.zeros(len(EFFECTS))
        factors[FACTORS.index("stiffness")] = math.log(stiffness)
        effects[EFFECTS.index("friction_voltage")] = voltage
        gaps = np.full(coarse.knots.size, math.radians(gap))
        beginning = initial_conditions_at_rest(coarse)
        candidates.append(Unknowns(gaps, factors, beginning, effects))
    for number, (steps, survivors) in enumerate(zip(ROUNDS, SURVIVORS, strict=True)):
        is_last = number == len(ROUNDS) - 1
        prior = knowledge if is_last else _without_late_readings(knowledge)
        problem = WindowFit(coarse, SETTINGS.growth_change, prior)
        fits = [problem.solve(each, steps, 2 * steps) for each in candidates]
        fits.sort(key=lambda fit: fit.residual)
        candidates = [fit.unknowns for fit in fits[:survivors]]
    motion = max(float(np.std(stretch.position)) for stretch in coarse.stretches)
    if not fits[0].residual <= ROUGH_MISFIT * motion:
        raise ValueError(
            f"the model does not explain {1e6 * fits[0].residual:.3g} um "
            f"of a motion of {1e6 * motion:.3g} um"
        )
    return candidates[0]
