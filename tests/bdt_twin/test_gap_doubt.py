"""How much less sure a gap is than its fit says."""

import math
from dataclasses import replace
from functools import cache

import pytest
from fitted_machine import last_fit_of_machine
from recorded_machine import Run
from unknown_machine import UnknownMachine

from bdt_twin.fit_doubt import FIRST_DOUBT
from bdt_twin.gap_doubt import (
    ALIKE,
    KNOWN_YIELDING,
    UNEXPLAINED_YIELDING,
    UNSEEN_YIELDING,
    YIELDING_DOUBT,
    doubted,
    yielding_doubt,
)
from bdt_twin.innovations import NoiseLevels
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.machine_memory import SMALLEST_FRICTION
from bdt_twin.unknowns import SMALLEST_YIELD_ANGLE

READING = 1e-7
SAID = math.radians(0.05)
QUIET, RESTLESS = (NoiseLevels(READING, 0.0, walk * READING, 0.0) for walk in (0.5, 20.0))


@cache
def explained():
    """Return window, fit and time of the last answer of a machine with friction alone."""
    last = last_fit_of_machine(UnknownMachine(coulomb_friction=0.01), Run(duration=12.0))
    return last.window, last.fit, last.estimate.time


def doubt(levels, reversals=20, cogs=0, friction=None, *, is_first=False):
    window, fit, at = explained()
    effects = fit.unknowns.effects.copy()
    if friction is not None:
        effects[EFFECTS.index("friction_voltage")] = friction
    unknowns = replace(fit.unknowns, effects=effects)
    whitening = fit.whitening.with_levels(levels)
    fit = replace(fit, unknowns=unknowns, levels=levels, whitening=whitening)
    return doubted(window.with_cogs(cogs), fit, at, SAID, reversals, is_first=is_first)


def test_a_fit_is_believed_where_the_machine_has_no_noise_or_its_cogging_is_known():
    assert doubt(NoiseLevels(READING, 0.0, 0.0, 0.0)) == SAID
    assert doubt(RESTLESS, reversals=1, cogs=24) == SAID


def test_a_motor_without_friction_would_have_shown_its_cogging():
    assert doubt(RESTLESS, reversals=1, friction=0.0) == SAID


def test_first_motions_tell_less():
    none = NoiseLevels(READING, 0.0, 0.0, 0.0)
    assert doubt(none, is_first=True) == pytest.approx(FIRST_DOUBT * SAID)


def yields(friction=0.15, angle=0.0, levels=QUIET, *, openness=0.0):
    _, fit, _ = explained()
    effects = fit.unknowns.effects.copy()
    effects[EFFECTS.index("friction_voltage")] = friction
    effects[EFFECTS.index("yield_angle")] = angle
    unknowns = replace(fit.unknowns, effects=effects)
    told = replace(fit, unknowns=unknowns, levels=levels)
    return yielding_doubt(told, openness=openness)


def test_friction_that_yields_is_known_by_a_share_of_its_angle():
    assert yields(angle=0.02) == yields(angle=0.02, levels=RESTLESS) == YIELDING_DOUBT * 0.02
    assert yields(angle=SMALLEST_YIELD_ANGLE) == KNOWN_YIELDING
    assert yields(0.5 * SMALLEST_FRICTION, angle=0.02) == YIELDING_DOUBT * 0.02


def test_friction_that_is_thought_to_be_rigid_may_yield_more_where_the_motor_walks():
    assert yields() == UNSEEN_YIELDING
    assert yields(levels=RESTLESS) == UNEXPLAINED_YIELDING > UNSEEN_YIELDING


def test_the_more_open_it_is_whether_friction_is_rigid_the_more_it_may_yield():
    assert yields(openness=1.0) == yields(levels=RESTLESS)
    assert yields() < yields(openness=0.5) < yields(openness=1.0)
    assert yields(angle=0.02, openness=1.0) == YIELDING_DOUBT * 0.02
    assert yields(0.5 * SMALLEST_FRICTION, openness=1.0) == 0.0


def test_a_motor_without_friction_has_none_that_yields():
    assert yields(friction=0.0, angle=0.02) == yields(friction=0.0, levels=RESTLESS) == 0.0


def test_a_little_that_looks_like_friction_is_not_thought_to_yield():
    assert yields(friction=0.5 * SMALLEST_FRICTION, levels=RESTLESS) == 0.0


def test_cogging_that_is_unknown_makes_the_gap_less_sure():
    assert doubt(QUIET) > SAID
    assert doubt(QUIET) == doubt(QUIET, reversals=1), "of a motor that does not walk"


def test_a_walk_that_few_reversals_have_seen_may_be_alike_at_each():
    many, few, one = (doubt(RESTLESS, reversals) for reversals in (400, 4, 1))
    assert few**2 - many**2 == pytest.approx(SAID**2 * (ALIKE / 4 - ALIKE / 400))
    assert one**2 - many**2 == pytest.approx(SAID**2 * (ALIKE - ALIKE / 400))
