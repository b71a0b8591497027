"""Of which reversals a fit tells the gap: those that the platform has answered as it should."""

import copy
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from fitted_machine import last_fit_of_machine
from recorded_machine import Run
from unknown_machine import UnknownMachine

from bdt_plant.plant import PlantModel
from bdt_twin.gap_of_fit import RESPONSE, answered_reversals
from bdt_twin.noise_levels import EXPLAINED

STRUCTURE = PlantModel().structure
ANSWER = RESPONSE * np.sqrt(STRUCTURE.mass / STRUCTURE.stiffness)
"""Time in which the platform answers the screw [s]."""
LATER = 100.0
"""A time by which all has been answered [s]."""


@cache
def explained():
    """Return window, fit, its reversals and the times at which its blocks end."""
    last = last_fit_of_machine(UnknownMachine(coulomb_friction=0.01), Run(duration=12.0))
    window, fit = last.window, last.fit
    (stretch,) = window.stretches
    ends = stretch.first / window.sampling_rate
    ends += np.arange(1, fit.innovations.size + 1) / window.block_rate
    return window, fit, window.reversals(fit.responses), ends


def answered(newest=LATER, pushed=None, unlike=None, error=1e-6):
    """Return the reversals that are answered.

    Parameters
    ----------
    newest : float
        Time of the newest sample [s].
    pushed, unlike : tuple of float
        Beginning and end [s] of blocks in which something pushes, and of those in which innovations
        are twice as large as noise.
    error : float
        Prediction error of the fit [m].
    """
    window, fit, _, ends = explained()
    whitening = copy.copy(fit.whitening)
    noise = np.random.default_rng(1).normal(size=ends.size)
    whitening.innovations, whitening.pushed = noise, np.zeros(ends.size)
    if unlike is not None:
        noise[(ends > unlike[0]) & (ends <= unlike[1])] *= 2.0
    if pushed is not None:
        whitening.pushed[(ends > pushed[0]) & (ends <= pushed[1])] = 1.0
    fit = replace(fit, whitening=whitening, prediction_error=error)
    return answered_reversals(PlantModel(), window, fit, newest)


def test_a_reversal_is_answered_when_the_platform_has_had_the_time():
    _, _, reversals, _ = explained()
    assert len(reversals) > 4
    last = reversals[-1]
    assert answered() == reversals
    assert answered(newest=last + 1.01 * ANSWER) == reversals
    assert answered(newest=last + 0.99 * ANSWER) == reversals[:-1]


@pytest.mark.parametrize("how", ["pushed", "unlike"])
def test_what_follows_with_a_push_or_otherwise_than_the_model_is_no_answer(how):
    """That is what a gap that has jumped looks like."""
    _, _, reversals, _ = explained()
    before, last = reversals[-2:]
    assert last - before > ANSWER
    assert answered(**{how: (last, last + ANSWER)}) == reversals[:-1]
    assert answered(**{how: (before, last + ANSWER)}) == reversals[:-2]


@pytest.mark.parametrize("how", ["pushed", "unlike"])
def test_what_comes_before_or_later_does_not_matter(how):
    _, _, reversals, ends = explained()
    last = reversals[-1]
    assert ends[-1] > last + 1.2 * ANSWER
    assert answered(**{how: (0.0, last)}) == reversals
    assert answered(**{how: (last + ANSWER, LATER)}) == reversals


def test_where_the_noise_is_next_to_nothing_all_is_an_answer_that_is_nearly_the_models():
    window, _, reversals, _ = explained()
    last = reversals[-1]
    tiny = 0.1 * EXPLAINED * window.motion
    assert answered(unlike=(last, last + ANSWER), error=tiny) == reversals
    assert answered(pushed=(last, last + ANSWER), error=tiny) == reversals[:-1]


def test_a_short_push_is_enough():
    _, _, reversals, ends = explained()
    block = int(np.searchsorted(ends, reversals[-1] + 0.5 * ANSWER))
    assert answered(pushed=(ends[block - 1], ends[block])) == reversals[:-1]


def test_an_answer_that_a_hole_hides_is_none():
    window, fit, reversals, ends = explained()
    last = reversals[-1]
    kept = int(np.searchsorted(ends, last))
    (stretch,), (run,) = window.stretches, fit.responses
    count = kept * window.block
    cut = copy.copy(window)
    cut.stretches = [
        stretch._replace(voltage=stretch.voltage[:count], position=stretch.position[:count])
    ]
    whitening = copy.copy(fit.whitening)
    whitening.innovations, whitening.pushed = np.zeros(kept), np.zeros(kept)
    responses = [run._replace(screw=run.screw[:kept])]
    fit = replace(fit, responses=responses, whitening=whitening)
    assert answered_reversals(PlantModel(), cut, fit, LATER) == reversals[:-1]
