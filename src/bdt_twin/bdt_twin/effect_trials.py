"""Effects of which a fit without them shows no evidence: how to try them, and what to believe.

A walk of the motor explains what they do about as well, so a window is fitted once more with one of
them. A trial that has failed leaves no trace, not even its work, which would keep others from being
made.
"""

import math
from collections.abc import Callable, Collection
from functools import partial
from typing import NamedTuple

import numpy as np

from bdt_twin.fit_result import Fit
from bdt_twin.fixed_order import dot
from bdt_twin.information import solved
from bdt_twin.machine_knowledge import EFFECTS, THREAD, TOP_MASS, VOLTAGE_LAG, MachineKnowledge
from bdt_twin.model_factors import FACTORS
from bdt_twin.noise_levels import HARDLY_EXPLAINED, is_restless
from bdt_twin.unknowns import LATE, Unknowns

TRIED_AGAIN = 3
"""Windows from the first trial of an effect to the second; then twice as many."""
LAG_GAIN = 10.0
"""Gain of log-likelihood by a voltage that is late, not the reading, for which it is taken so."""
CERTAIN_GAIN = 15.0
"""Gain of log-likelihood for which an effect is believed that is certain."""
TOP_MASS_COVERAGE, LEAST_TOP_MASS = 4.0, 0.01
"""Standard uncertainties by which the mass of the top platform has to be another one, and logarithm
of the factor on it below which it is none."""
THREAD_COVERAGE, LEAST_THREAD_ERROR = 5.0, 1e-7
"""Standard uncertainties by which the thread has to be off, and what is no error of it [m]."""
FIRST_TOP_MASS, FIRST_THREAD_ERROR = 1e-3, 1e-9
"""With what a trial begins: nothing would have no slope."""
WITHOUT_SLOPE = {TOP_MASS: FIRST_TOP_MASS, **dict.fromkeys(THREAD, FIRST_THREAD_ERROR)}
"""What a fit has to begin with to find them, by places in ``EFFECTS``."""


class EffectTrial(NamedTuple):
    """How an effect is tried.

    Attributes
    ----------
    places : tuple of int
        Places in ``EFFECTS`` of its parts.
    begun : callable
        Returns the unknowns with which the trial begins, for those of a fit without the effect.
    is_possible : callable
        Tells from what a window has told of a machine whether it may have the effect.
    is_believed : callable
        Tells from a window's fits with and without it whether a machine has the effect.
    """

    places: tuple[int, ...]
    begun: Callable[[Unknowns], Unknowns]
    is_possible: Callable[[MachineKnowledge], bool]
    is_believed: Callable[[Fit, Fit], bool]


def has_late_reading(machine: MachineKnowledge) -> bool:
    """Tell whether readings are late, for which a voltage that is late is taken.

    Parameters
    ----------
    machine : MachineKnowledge
        What a window has told.
    """
    return bool(machine.expected[len(FACTORS) + EFFECTS.index("delay")] >= LATE)


def explains_late_voltage(found: Fit, fit: Fit) -> bool:
    """Tell whether a voltage is late, not the reading.

    What other effects leave unexplained may want a voltage that is late and a reading that is
    early, which no machine has, and one more unknown lets a motor walk less that goes on to walk a
    lot.

    Parameters
    ----------
    found, fit : Fit
        A window's fits with and without it.
    """
    is_explained = not is_restless(found.levels, HARDLY_EXPLAINED)
    gains = found.gain_over(fit) >= LAG_GAIN
    return gains and found.unknowns.has_late_voltage and is_explained


def is_certain(
    found: Fit, fit: Fit, *, places: tuple[int, ...], coverage: float, least: float
) -> bool:
    """Tell whether an effect is there for certain, however much of the motion is left.

    Parameters
    ----------
    found, fit : Fit
        A window's fits with and without it.
    places : tuple of int
        Places in ``EFFECTS`` of its parts.
    coverage : float
        Standard uncertainties that its parts together have to be off zero.
    least : float
        Size of all parts together below which there is none.
    """
    known = [len(FACTORS) + place for place in places]
    parts, covariance = found.machine.expected[known], found.machine.covariance
    size = math.sqrt(dot(parts, parts))
    squares = dot(parts, solved(covariance[np.ix_(known, known)], parts))
    is_off = squares > coverage * coverage and size > least
    return found.gain_over(fit) >= CERTAIN_GAIN and is_off


def _trial(places: tuple[int, ...], first: float, coverage: float, least: float) -> EffectTrial:
    """Return the trial of an effect that is believed once it is certain."""
    return EffectTrial(
        places,
        partial(Unknowns.with_effects, places=places, size=first),
        lambda _: True,
        partial(is_certain, places=places, coverage=coverage, least=least),
    )


LATE_VOLTAGE = EffectTrial(
    (VOLTAGE_LAG,), Unknowns.with_late_voltage, has_late_reading, explains_late_voltage
)
"""An amplifier that lags."""
OTHER_TOP_MASS = _trial((TOP_MASS,), FIRST_TOP_MASS, TOP_MASS_COVERAGE, LEAST_TOP_MASS)
"""A payload, or upper beams that are as stiff as others are not."""
THREAD_ERROR = _trial(
    tuple(sorted(THREAD)), FIRST_THREAD_ERROR, THREAD_COVERAGE, LEAST_THREAD_ERROR
)
"""A screw whose travel is off by a wave of its angle."""
TRIALS = (LATE_VOLTAGE, OTHER_TOP_MASS, THREAD_ERROR)
"""All of them, the first one first."""
TRIED = frozenset(place for trial in TRIALS for place in trial.places)
"""Places in ``EFFECTS`` of what is tried."""


def of_present(known: MachineKnowledge, present: Collection[int]) -> MachineKnowledge:
    """Return knowledge of a machine that has some effects only.

    What a fit does not find that begins without any is expected to be a little, not nothing.

    Parameters
    ----------
    known : MachineKnowledge
        What is known, which this may change.
    present : collection of int
        Places in ``EFFECTS`` of what it has.
    """
    for place in WITHOUT_SLOPE.keys() & present:
        if known.expected[len(FACTORS) + place] == 0.0:
            known.expected[len(FACTORS) + place] = WITHOUT_SLOPE[place]
    return known.without(set(range(len(EFFECTS))) - set(present))


class TrialTimes:
    """Says when it is time for a trial: for each less and less often."""

    def __init__(self) -> None:
        self._pauses = dict.fromkeys(TRIALS, TRIED_AGAIN)
        self._left = dict.fromkeys(TRIALS, 1)

    def due(self, present: Collection[int], machine: MachineKnowledge) -> EffectTrial | None:
        """Count a window in which something may be tried; return what is to be, None for nothing.

        Parameters
        ----------
        present : collection of int
            Places in ``EFFECTS`` of those that the machine has.
        machine : MachineKnowledge
            What the window has told of it.
        """
        for trial in TRIALS:
            is_absent = set(present).isdisjoint(trial.places)
            if is_absent and trial.is_possible(machine) and self._is_due(trial):
                return trial
        return None

    def _is_due(self, trial: EffectTrial) -> bool:
        self._left[trial] -= 1
        if self._left[trial] > 0:
            return False
        self._left[trial] = self._pauses[trial]
        self._pauses[trial] *= 2
        return True
