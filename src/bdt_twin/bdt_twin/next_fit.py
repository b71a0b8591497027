"""The fit of a window that follows others: from their prediction, with what the machine has."""

import math
from dataclasses import dataclass, replace

from bdt_twin.cogging_search import cogging_evidence
from bdt_twin.estimator import Estimate
from bdt_twin.fit_result import Fit
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.noise_levels import quiet
from bdt_twin.window_model import WindowModel
from bdt_twin.window_prediction import Predecessor, predicted_unknowns, without_growth
from bdt_twin.window_search import FINE, fit_window

MOST_NEWCOMERS = 2
"""Effects that may join the unknowns in one window; each takes another fit."""
MUCH_WORK = 600_000
"""Simulated samples after which an effect joins in the next window only, if one fit of the window
does not take more."""


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
    begins = window.stretches[0].first / (window.block_rate * window.block)
    predicted, otherwise, error, levels = None, None, math.inf, None
    if last is not None:
        predicted = predicted_unknowns(window, last)
        otherwise = without_growth(window, last, predicted)
        error, levels = last.fit.prediction_error, last.fit.levels
    known = machine.before(begins)
    fit = fit_window(window, growth_change, known, predicted, error, levels, otherwise)
    for _ in range(MOST_NEWCOMERS):
        if fit.simulated > max(MUCH_WORK, FINE * window.samples):
            break
        levels = fit.levels
        if machine.has_evidence(fit.evidence, fit.machine):
            pass
        elif machine.looks_for_cogging(fit.levels) and machine.has_cogging(
            cogging_evidence(window, fit)
        ):
            window, levels = window.with_cogs(machine.cogs), quiet(fit.levels)
        else:
            break
        # What explains more is found from here; the error may only become smaller.
        known = machine.before(begins)
        found = fit_window(window, growth_change, known, fit.unknowns, math.inf, levels)
        fit = replace(found, simulated=fit.simulated + found.simulated)
    return window, fit
