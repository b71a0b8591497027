"""The fit of a window that follows others: from their prediction, with what the machine has."""

import math
from dataclasses import dataclass, replace

from bdt_twin.cogging_search import cogging_evidence
from bdt_twin.estimator import Estimate
from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import COGGING
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.noise_levels import quiet
from bdt_twin.window_model import WindowModel
from bdt_twin.window_prediction import Predecessor, predicted_unknowns, without_growth
from bdt_twin.window_search import FINE, fit_another_machine, fit_window

MOST_NEWCOMERS = 2
"""Effects that may join the unknowns in one window; each takes another fit."""
MUCH_WORK = 600_000
"""Simulated samples after which an effect joins in the next window only, if one fit of the window
does not take more, and none is tried."""
BETTER = 4.0
"""Gain of log-likelihood by which another number of periods has to be better than the known one."""


@dataclass(frozen=True, eq=False)
class AcceptedFit:
    """The last window that taught something.

    Attributes
    ----------
    window : WindowModel
        Model and data.
    fit : Fit
        The model fitted to the data.
    estimate : Estimate
        What it taught.
    """

    window: WindowModel
    fit: Fit
    estimate: Estimate

    @property
    def reading_noise(self) -> float:
        """Standard deviation of the noise of a single reading [m], were it white."""
        return self.fit.levels.reading * math.sqrt(self.window.readings_per_block)


def last_fit_of(estimator: object) -> AcceptedFit | None:
    """Return what the last window has taught an estimator; None from one that fits no model."""
    last_fit = getattr(estimator, "last_fit", None)
    return last_fit if isinstance(last_fit, AcceptedFit) else None


def next_fit(
    window: WindowModel, last: Predecessor | None, machine: MachineMemory, growth_change: float
) -> tuple[WindowModel, Fit]:
    """Fit a window, beginning with the last fit if it still describes the data.

    An effect of the machine joins the unknowns when a window gives evidence of it.

    Parameters
    ----------
    window : WindowModel
        Model and data.
    last : Predecessor or None
        The window before that was explained.
    machine : MachineMemory
        What is known of the machine; told of effects that join.
    growth_change : float
        Scale of the growth rate's change in one second [rad/s^1.5].

    Returns
    -------
    window : WindowModel
        Model and data, with the cogging that was found.
    fit : Fit
        Its fit.
    """
    predicted, otherwise, error, levels = None, None, math.inf, None
    if last is not None:
        predicted = predicted_unknowns(window, last)
        otherwise = without_growth(window, last, predicted)
        error, levels = last.fit.prediction_error, last.fit.levels
    known = machine.before(*window.span)
    fit = fit_window(window, growth_change, known, predicted, error, levels, otherwise)
    for _ in range(MOST_NEWCOMERS):
        if fit.simulated > max(MUCH_WORK, FINE * window.samples):
            break
        if machine.has_evidence(fit.evidence, fit.machine):
            # What explains more is found from here; the error may only become smaller.
            known = machine.before(*window.span)
            found = fit_window(window, growth_change, known, fit.unknowns, math.inf, fit.levels)
            fit = replace(found, simulated=fit.simulated + found.simulated)
        elif machine.looks_for_cogging(fit.levels):
            searched = window
            window, fit = _with_cogging(window, fit, machine, growth_change)
            if window is searched:
                break
        else:
            break
    return window, _with_what_is_tried(window, fit, machine, growth_change)


def _with_what_is_tried(
    window: WindowModel, fit: Fit, machine: MachineMemory, growth_change: float
) -> Fit:
    """Return the fit of a window with an effect whose trial is due, if the machine has it."""
    trial = None if fit.simulated > MUCH_WORK else machine.to_try(fit.levels, fit.machine)
    if trial is None:
        return fit
    begun = trial.begun(fit.unknowns)
    known = machine.with_effects(begun.effects, trial.places)
    found = fit_another_machine(window, growth_change, known, begun, fit.levels)
    if not trial.is_believed(found, fit):
        return fit
    machine.has_effects(begun.effects, trial.places)
    return replace(found, simulated=fit.simulated + found.simulated)


def _with_cogging(
    window: WindowModel, fit: Fit, machine: MachineMemory, growth_change: float
) -> tuple[WindowModel, Fit]:
    """Return a window with the cogging for which there is evidence, and its fit.

    A number of periods that is known already stays, unless the fit with another one is better: the
    evidence tells what small waves would explain, and these are not small.
    """
    evidence = cogging_evidence(window, fit)
    if not machine.suspects_cogging(evidence):
        return window, fit
    other, effects = window.with_cogs(evidence.cogs), fit.unknowns.effects.copy()
    effects[sorted(COGGING)] = 0.0
    begun = replace(fit.unknowns, effects=effects)
    known = machine.before(*window.span).forgetting(COGGING)
    found = fit_window(other, growth_change, known, begun, math.inf, quiet(fit.levels))
    simulated = fit.simulated + found.simulated
    if window.cogs and found.gain_over(fit) < BETTER:
        machine.keeps_cogging()
        return window, replace(fit, simulated=simulated)
    machine.has_cogging(evidence.cogs)
    return other, replace(found, simulated=simulated)
