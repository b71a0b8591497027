"""The fit of a window that follows others: from their prediction, with what the machine has."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bdt_twin.cogging_search import cogging_evidence
from bdt_twin.estimator import Estimate
from bdt_twin.fit_result import Fit
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.noise_levels import quiet
from bdt_twin.unknowns import Unknowns
from bdt_twin.window_model import WindowModel
from bdt_twin.window_search import fit_window, initial_conditions_at_rest

MOST_NEWCOMERS = 2
"""Effects that may join the unknowns in one window; each takes another fit."""


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


class Predecessor(NamedTuple):
    """A window before, from which the fit of the next one begins.

    Attributes
    ----------
    window : WindowModel
        Model and data.
    fit : Fit
        The model fitted to the data; it may leave the gap unknown.
    growth : float
        Growth rate of the gap at its end [rad/s].
    """

    window: WindowModel
    fit: Fit
    growth: float


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
    predicted, error, levels = None, math.inf, None
    if last is not None:
        predicted = _predict_unknowns(window, last)
        error, levels = last.fit.prediction_error, last.fit.levels
    known = machine.before(begins)
    fit = fit_window(window, growth_change, known, predicted, error, levels)
    for _ in range(MOST_NEWCOMERS):
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
        fit = fit_window(window, growth_change, known, fit.unknowns, math.inf, levels)
    return window, fit


def _predict_unknowns(window: WindowModel, last: Predecessor) -> Unknowns:
    """Return the unknowns that the last fit predicts for a window."""
    before, fit, knots = last.window, last.fit, window.knots
    beyond = np.maximum(knots - before.knots[-1], 0.0)
    # Both windows' knots are multiples of the spacing, so that nothing is rounded.
    gaps = np.interp(knots, before.knots, fit.unknowns.gaps) + last.growth * beyond
    gaps = np.maximum(gaps, 0.0)
    initial_conditions = initial_conditions_at_rest(window)
    rate = window.block_rate * window.block
    for beginning, stretch in zip(initial_conditions, window.stretches, strict=True):
        half = 0.5 * window.gap_at(gaps, stretch.first / rate)
        for old, run in zip(before.stretches, fit.responses, strict=True):
            sample = stretch.first - old.first
            if 0 <= sample < run.relative_angle.size and half > 0.0:
                beginning[0] = min(max(run.relative_angle[sample] / half, -1.0), 1.0)
    return Unknowns(gaps, fit.unknowns.factors, initial_conditions, fit.unknowns.effects)
