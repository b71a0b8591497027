"""Search for the best fit of a window: from a prediction, or from many gaps."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from bdt_twin.fit_doubt import is_surprised
from bdt_twin.fit_result import Fit
from bdt_twin.innovations import NoiseLevels
from bdt_twin.machine_knowledge import MachineKnowledge
from bdt_twin.machine_memory import SMALLEST_FRICTION
from bdt_twin.model_factors import FACTORS
from bdt_twin.noise_levels import EXPLAINED, is_restless, is_slight, quiet
from bdt_twin.output_error_fit import WindowFit
from bdt_twin.unknowns import INITIAL_CONDITION, Unknowns
from bdt_twin.window_model import WindowModel

FloatArray = NDArray[np.float64]

FIRST_GAPS = (8.0, 28.0, 2.0, 16.0)
"""Gaps from which a fit without a predecessor begins [deg]."""
AGREED = 1.1
"""Ratio of the residuals below which two initial conditions have led to the same fit."""
ROUGH, FINE = 5, 12
"""Largest numbers of steps of a fit to choose a beginning by, and of one that counts."""
PREDICTION_SIMULATIONS = 4
"""Simulations after which a prediction has to describe the data."""
MOST_SAMPLES, MOST_FOLLOWING, MOST_OF_ANOTHER = 240_000, 200_000, 100_000
"""Samples that a fit may simulate that begins somewhere, that follows a prediction, and that is of
another machine: this bounds the time that it takes."""
FEWEST_SIMULATIONS = 9
"""Simulations that a fit may make, however long the window is."""
FEWEST_OF_ANOTHER = 3
"""Simulations of a fit of another machine, however long the window is."""
ROUGH_SIMULATIONS = 6
"""Simulations of a fit to which the machine's noise is not known yet, or that is tried besides."""
COARSE_RATE, COARSE_BLOCK_RATE = 500.0, 50.0
"""Lowest rates at which a beginning is chosen [Hz]: motor and structure are hardly faster."""
WORSE = 2.0
"""Growth of the residual from window to window that makes the fit begin anew."""
QUIETER_ERROR = 1.1
"""Growth of the prediction error for which a motor that rested is thought to walk again."""
WORSE_ERROR = 1.1
"""Growth of the prediction error for which another prediction is tried."""


def initial_conditions_at_rest(window: WindowModel) -> FloatArray:
    """Return the initial conditions of stretches at rest, the motor in the middle of the gap."""
    initial_conditions = np.zeros((len(window.stretches), len(INITIAL_CONDITION)))
    initial_conditions[:, INITIAL_CONDITION.index("offset")] = [
        stretch.position[0] for stretch in window.stretches
    ]
    return initial_conditions


def fit_window(
    window: WindowModel,
    growth_change: float,
    machine: MachineKnowledge,
    predicted: Unknowns | None = None,
    error: float = math.inf,
    levels: NoiseLevels | None = None,
    otherwise: Unknowns | None = None,
) -> Fit:
    """Fit a window, beginning with a prediction if that describes the data.

    Otherwise initial conditions with different gaps are tried on a coarse copy of the window. How
    often the window itself is simulated is limited, and so is the time that this takes: what a
    fit has not reached by then is reached from there in the next windows.

    Parameters
    ----------
    window : WindowModel
        Model and data.
    growth_change : float
        Scale of the growth rate's change in one second [rad/s^1.5].
    machine : MachineKnowledge
        What is known of the machine before.
    predicted : Unknowns or None
        What the fit of the window before predicts.
    error : float
        Prediction error of that fit [m].
    levels : NoiseLevels or None
        Levels of noise of that fit.
    otherwise : Unknowns or None
        Another prediction, tried where the fit that begins with the first one leaves something of
        the newest data unexplained.
    """
    problem = WindowFit(window, growth_change, machine)
    most = MOST_SAMPLES if predicted is None else MOST_FOLLOWING
    simulations = max(most // window.samples, FEWEST_SIMULATIONS)
    if predicted is None:
        return _from_many(problem, window, growth_change, machine, simulations)
    enough = _enough(window, error)
    # What a model explains is not taken for a walk of the motor only because it was before.
    may_rest = levels is not None and is_restless(levels)
    rested = None if levels is None else quiet(levels)
    first = rested if levels is None or may_rest or is_slight(levels) else levels
    follow = partial(
        problem.solve,
        steps=FINE,
        simulations=simulations,
        levels=first,
        patience=PREDICTION_SIMULATIONS,
        enough=enough,
    )
    again = partial(problem.solve, steps=FINE, simulations=ROUGH_SIMULATIONS)
    followed = follow(predicted)
    if first is not rested and not window.cogs and predicted.friction < SMALLEST_FRICTION:
        # There is little that lets such a motor walk: rather, a fit ended too early.
        followed = _better(followed, again(predicted, levels=rested))
    if may_rest and followed.prediction_error > QUIETER_ERROR * error:
        followed = _better(followed, again(predicted, levels=levels))
    if may_rest and followed.prediction_error > error:
        # Where a motor that walks is in its gap was a guess already, and may be a wrong one.
        begun = _in_the_middle_of_the_gap(predicted)
        followed = _better(followed, again(begun, levels=rested))
    # A push that nobody gave may explain the newest data, but not as well.
    is_worse = not may_rest and followed.prediction_error > WORSE_ERROR * error
    if otherwise is not None and (is_worse or leaves_newest_unexplained(window, followed)):
        followed = _better(followed, follow(otherwise))
    if followed.prediction_error <= enough:
        return followed
    return _better(followed, _from_many(problem, window, growth_change, machine, simulations))


def fit_another_machine(
    window: WindowModel,
    growth_change: float,
    machine: MachineKnowledge,
    begun: Unknowns,
    levels: NoiseLevels,
) -> Fit:
    """Return the fit of a window, fitted already, to a machine that is thought to be another one.

    Parameters
    ----------
    window : WindowModel
        Model and data.
    growth_change : float
        Scale of the growth rate's change in one second [rad/s^1.5].
    machine : MachineKnowledge
        What is known of the other machine before.
    begun : Unknowns
        Where the fit begins.
    levels : NoiseLevels
        Levels of noise of the fit that it is compared with.
    """
    problem = WindowFit(window, growth_change, machine)
    simulations = max(MOST_OF_ANOTHER // window.samples, FEWEST_OF_ANOTHER)
    # What a model explains is not taken for a walk of the motor only because it was before.
    first = quiet(levels) if is_restless(levels) else levels
    return problem.solve(begun, FINE, simulations, levels=first)


def explains_worse(window: WindowModel, fit: Fit, error: float) -> bool:
    """Return whether a fit explains its window much worse than that before was explained.

    Parameters
    ----------
    window : WindowModel
        Model and data.
    fit : Fit
        Their fit.
    error : float
        Prediction error of the window before [m].
    """
    return fit.prediction_error > _enough(window, error)


def _enough(window: WindowModel, error: float) -> float:
    """Return the prediction error with which a window is explained as the one before was [m]."""
    return max(WORSE * error, EXPLAINED * window.motion)


def _better(one: Fit, other: Fit) -> Fit:
    """Return the fit that predicts better, with the work of both."""
    better = min(one, other, key=lambda each: each.prediction_error)
    return replace(better, simulated=one.simulated + other.simulated)


def _in_the_middle_of_the_gap(unknowns: Unknowns) -> Unknowns:
    """Return the unknowns for stretches that begin with the motor in the middle of the gap."""
    initial_conditions = unknowns.initial_conditions.copy()
    initial_conditions[:, INITIAL_CONDITION.index("share")] = 0.0
    return replace(unknowns, initial_conditions=initial_conditions)


def leaves_newest_unexplained(window: WindowModel, fit: Fit) -> bool:
    """Return whether a fit explains the newest data of its window worse than the others."""
    negligible = fit.negligible(window.motion)
    return is_surprised(fit.innovations, fit.pushed, fit.levels, window.block_rate, negligible)


def _from_many(
    problem: WindowFit,
    window: WindowModel,
    growth_change: float,
    machine: MachineKnowledge,
    simulations: int,
) -> Fit:
    """Fit a window from the best of many beginnings: roughly, then with the machine's noise."""
    begun = multi_start(window, growth_change, machine)
    near = problem.solve(begun.unknowns, ROUGH, ROUGH_SIMULATIONS)
    rest = simulations - near.simulated // window.samples
    fit = problem.solve(near.unknowns, FINE, rest, levels=near.levels)
    return replace(fit, simulated=begun.simulated + near.simulated + fit.simulated)


def multi_start(window: WindowModel, growth_change: float, machine: MachineKnowledge) -> Fit:
    """Return the best fit of a coarse copy of a window, of those that begin with each first gap.

    Parameters
    ----------
    window : WindowModel
        Model and data.
    growth_change : float
        Scale of the growth rate's change in one second [rad/s^1.5].
    machine : MachineKnowledge
        What is known of the machine before.
    """
    coarse = window.coarse(COARSE_RATE, COARSE_BLOCK_RATE)
    problem = WindowFit(coarse, growth_change, machine)
    factors, effects = np.split(machine.expected, [len(FACTORS)])
    fits: list[Fit] = []
    for gap in FIRST_GAPS:
        gaps = np.full(window.knots.size, math.radians(gap))
        first = Unknowns(gaps, factors, initial_conditions_at_rest(window), effects)
        fits.append(problem.solve(first, ROUGH, 2 * ROUGH))
        least = min(fit.residual for fit in fits)
        if sum(fit.residual < AGREED * least for fit in fits) > 1:
            break
    best = min(fits, key=lambda fit: fit.residual)
    return replace(best, simulated=sum(fit.simulated for fit in fits))
