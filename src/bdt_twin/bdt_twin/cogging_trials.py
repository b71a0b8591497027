"""Search for the cogging of a motor whose windows nothing else explains: number after number.

Cogging that moves a motor from well to well is no small correction of a fit without it, and its
number of periods has to be tried. That takes longer than one window has, so data of a few seconds
are kept until all numbers had their turn; the best of them then have to agree with other data.
"""

import math
from typing import NamedTuple

from bdt_plant.motor import MotorParameters
from bdt_twin.cogging_waves import NUMBERS
from bdt_twin.fit_result import Fit
from bdt_twin.innovations import NoiseLevels
from bdt_twin.machine_knowledge import COGGING, EFFECTS, MachineKnowledge, first_knowledge
from bdt_twin.machine_memory import MachineMemory
from bdt_twin.noise_levels import is_restless, quiet
from bdt_twin.output_error_fit import WindowFit
from bdt_twin.unknowns import Unknowns
from bdt_twin.window_model import WindowModel
from bdt_twin.window_prediction import Predecessor, predicted_unknowns
from bdt_twin.window_search import COARSE_BLOCK_RATE, COARSE_RATE, FINE, multi_start

LONGEST, SHORTEST = 6.0, 4.0
"""Time that the data of a trial cover [s]: in a longer one there are more wrong fits, and a shorter
one does not tell a number from the next."""
TRIALS, FINAL_TRIALS = 2, 1
"""Numbers that are tried in each window that teaches nothing."""
MUCH_WORK = 500_000
"""Simulated samples of a window's own fits that leave no time for trials."""
FINALISTS = 5
"""Numbers that are tried on other data."""
DISTINCT = 0.93
"""Prediction error of the best number over that of any other for which other data are looked at."""
CERTAIN = 0.82
"""The same, multiplied over both data, of a number that is the right one."""
EXPLAINS = 0.9
"""Prediction error with the right number over that without cogging."""
ALSO = 1.05
"""Prediction error on the other data over the least one there."""
SUSPECTED = frozenset(
    map(
        EFFECTS.index,
        ("friction_voltage", "voltage_offset", "delay", "excess_voltage", "stribeck_speed"),
    )
)
"""Effects that any machine may have; what else a fit without cogging has found may be cogging."""
ROUNDS = tuple(
    (anew, tuple(number for number in NUMBERS if number % 2 == odd))
    for odd in (0, 0, 1)
    for anew in (True, False)
)
"""Whether a round begins with nothing known of the machine, and its numbers. Even ones come first:
motors with pairs of equal poles have no others."""


class FoundCogging(NamedTuple):
    """Cogging that explains what nothing else did.

    Attributes
    ----------
    cogs : int
        Periods in a turn.
    present : frozenset of int
        Places in ``EFFECTS`` of what the machine may have besides.
    window : Predecessor
        Data that it explains, from which the next window's fit may begin.
    """

    cogs: int
    present: frozenset[int]
    window: Predecessor


class _Trial(NamedTuple):
    """Data on which numbers are tried, and what is known before.

    All fits begin at the same unknowns; those that count for certain with a search of their own,
    too.
    """

    window: WindowModel
    coarse: WindowModel
    beginning: Unknowns
    known: MachineKnowledge
    levels: NoiseLevels
    growth_change: float
    is_final: bool

    def fit(self, cogs: int) -> Fit:
        """Return a fit of few samples."""
        fit = self._fit_from(self.beginning, cogs)
        if self.is_final:
            window = self.window.with_cogs(cogs)
            begun = multi_start(window, self.growth_change, self.known)
            own = self._fit_from(begun.unknowns, cogs)
            fit = min(fit, own, key=lambda each: each.prediction_error)
        return fit

    def _fit_from(self, beginning: Unknowns, cogs: int) -> Fit:
        problem = WindowFit(self.coarse.with_cogs(cogs), self.growth_change, self.known)
        return problem.solve(beginning, FINE, FINE, levels=self.levels)

    def fine_fit(self, cogs: int, coarse: Fit) -> Predecessor:
        """Return a fit of all samples that begins with one of few."""
        window = self.window.with_cogs(cogs)
        problem = WindowFit(window, self.growth_change, self.known)
        fit = problem.solve(coarse.unknowns, FINE, FINE, levels=coarse.levels)
        return Predecessor(window, fit, 0.0)


class CoggingTrials:
    """Tries a few numbers in each window that teaches nothing, if its own fit leaves time for it.

    Parameters
    ----------
    motor : MotorParameters
        The motor, as the twin knows it.
    """

    def __init__(self, motor: MotorParameters) -> None:
        self._motor = motor
        self._rounds = list(ROUNDS)
        self._trial: _Trial | None = None
        self._waiting: list[int] = []
        self._fits: dict[int, Fit] = {}
        self._before: dict[int, float] = {}

    def advance(
        self, window: WindowModel, fit: Fit, machine: MachineMemory, growth_change: float
    ) -> FoundCogging | None:
        """Try the next numbers.

        Parameters
        ----------
        window : WindowModel
            A window that has taught nothing.
        fit : Fit
            Its fit.
        machine : MachineMemory
            What is known of the machine.
        growth_change : float
            Scale of the growth rate's change in one second [rad/s^1.5].

        Returns
        -------
        FoundCogging or None
            The cogging, once a number is the best by far, twice.
        """
        has_time = fit.simulated <= MUCH_WORK
        if not (has_time and self._rounds and is_restless(fit.levels)):
            return None
        anew, numbers = self._rounds[0]
        if self._trial is None:
            self._trial = self._begin(window, fit, machine, growth_change, anew=anew)
            if self._trial is None:
                return None
            cogs = window.cogs
            self._waiting = [cogs, *(each for each in self._before or numbers if each != cogs)]
            self._fits = {}
        trials = FINAL_TRIALS if self._before else TRIALS
        for _ in range(min(trials, len(self._waiting))):
            number = self._waiting.pop(0)
            self._fits[number] = self._trial.fit(number)
        return None if self._waiting else self._end(self._trial, machine, anew=anew)

    def _begin(
        self,
        window: WindowModel,
        fit: Fit,
        machine: MachineMemory,
        growth_change: float,
        *,
        anew: bool,
    ) -> _Trial | None:
        """Return the newest data of a window for a round; None if they do not suffice."""
        newest = window.newest(LONGEST)
        if newest.samples < SHORTEST * newest.sampling_rate or newest.motion < 0.5 * window.motion:
            return None
        if anew:
            known = first_knowledge(self._motor).without(set(range(len(EFFECTS))) - SUSPECTED)
        else:
            known = machine.before(*newest.span)
        if anew:
            beginning = multi_start(newest, growth_change, known).unknowns
        elif newest is window:
            beginning = fit.unknowns
        else:
            beginning = predicted_unknowns(newest, Predecessor(window, fit, 0.0))
        coarse = newest.coarse(COARSE_RATE, COARSE_BLOCK_RATE)
        known = known.forgetting(COGGING)
        levels, is_final = quiet(fit.levels), bool(self._before)
        return _Trial(newest, coarse, beginning, known, levels, growth_change, is_final)

    def _end(self, trial: _Trial, machine: MachineMemory, *, anew: bool) -> FoundCogging | None:
        """Return the cogging that the last trial of a round has told for certain."""
        self._trial = None
        cogs, before, self._before = trial.window.cogs, self._before, {}
        errors = {number: fit.prediction_error for number, fit in self._fits.items()}
        if before:
            both = {
                number: error * before.get(number, math.inf) for number, error in errors.items()
            }
            best, is_certain = _clear_best(both, cogs, CERTAIN)
            # One of both may have been hit by chance.
            is_certain &= errors[best] < min(errors[cogs], ALSO * min(errors.values()))
        else:
            best, is_certain = _clear_best(errors, cogs, DISTINCT)
        if before or not is_certain:
            self._rounds = self._rounds[1:]
        if not is_certain:
            return None
        if before:
            present = SUSPECTED if anew else machine.present
            return FoundCogging(best, present, trial.fine_fit(best, self._fits[best]))
        ranked = sorted(errors, key=errors.__getitem__)[:FINALISTS]
        self._before = {number: errors[number] for number in dict.fromkeys([cogs, *ranked])}
        return None


def _clear_best(errors: dict[int, float], cogs: int, most: float) -> tuple[int, bool]:
    """Return the number with the least error, and whether it is that by far.

    Parameters
    ----------
    errors : dict
        Prediction errors by number.
    cogs : int
        The number that the machine was thought to have.
    most : float
        Largest error over that of any other.
    """
    best, second = sorted(errors.keys() - {cogs}, key=errors.__getitem__)[:2]
    return best, errors[best] < min(most * errors[second], EXPLAINS * errors[cogs])
