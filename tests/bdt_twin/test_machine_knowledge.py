"""What is known of a machine: how it is forgotten, doubted, and left out."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_plant.motor import MotorParameters
from bdt_twin.machine_knowledge import (
    EFFECT_LIMITS,
    EFFECT_SPREAD,
    EFFECTS,
    FACTOR_SPREAD,
    MachineKnowledge,
    first_knowledge,
)
from bdt_twin.model_factors import FACTORS

SPREAD = np.array([*FACTOR_SPREAD, *EFFECT_SPREAD])
COUNT = len(FACTORS) + len(EFFECTS)
SEEDS = st.integers(0, 10_000)
SUBSETS = st.sets(st.sampled_from(range(len(EFFECTS))))


def told(seed):
    """Return what a window may have told: surer than at first, and correlated."""
    random = np.random.default_rng(seed)
    mixed = random.normal(size=(COUNT, 2 * COUNT))
    correlated = mixed @ mixed.T / (2 * COUNT)
    scale = SPREAD * random.uniform(0.01, 0.3, COUNT)
    return MachineKnowledge(scale * random.normal(size=COUNT), correlated * np.outer(scale, scale))


def widens(wide, narrow):
    """Whether no combination of the constants is surer in the one than in the other."""
    difference = (wide.covariance - narrow.covariance) / np.outer(SPREAD, SPREAD)
    return np.linalg.eigvalsh(difference).min() > -1e-12


def after_data(known, measured, deviations):
    """Return what is expected after a measurement of all constants: Bayes with numpy."""
    precision = np.diag(1.0 / np.square(deviations))
    right = known.precision() @ known.expected + precision @ measured
    return np.linalg.solve(known.precision() + precision, right)


def test_a_machine_that_nobody_has_looked_at_is_the_model_as_it_is():
    known = first_knowledge(MotorParameters())
    assert (known.expected == 0.0).all()
    assert np.sqrt(np.diag(known.covariance)) == pytest.approx(SPREAD)
    assert (known.covariance == np.diag(np.diag(known.covariance))).all()


def test_friction_of_the_model_is_expected_as_the_voltage_that_a_standing_motor_needs():
    motor = MotorParameters(coulomb_friction=0.01)
    known = first_knowledge(motor)
    friction = known.expected[len(FACTORS) + EFFECTS.index("friction_voltage")]
    # k_T i = tau and u = R i.
    assert friction == pytest.approx(0.01 / motor.torque_constant * motor.resistance)
    assert np.count_nonzero(known.expected) == 1


def test_what_is_expected_is_within_the_limits_of_each_effect():
    lowest, highest = EFFECT_LIMITS
    assert (lowest < highest).all()
    expected = first_knowledge(MotorParameters()).expected[len(FACTORS) :]
    assert ((lowest <= expected) & (expected <= highest)).all()
    assert (np.array(EFFECT_SPREAD) < highest).all()


@given(SEEDS, SUBSETS)
def test_absent_effects_stay_where_they_are_whatever_the_data_say(seed, absent):
    known = told(seed).without(absent)
    places = [len(FACTORS) + effect for effect in sorted(absent)]
    far = known.expected + 3.0 * SPREAD
    found = after_data(known, far, 0.01 * SPREAD)
    moved = np.abs(found - known.expected) / SPREAD
    assert (moved[places] < 1e-6).all()
    assert (np.delete(moved, places) > 0.1).all()


@given(SEEDS, SUBSETS)
def test_all_other_knowledge_stays_when_an_effect_is_left_out_or_forgotten(seed, effects):
    known = told(seed)
    others = np.delete(np.arange(COUNT), [len(FACTORS) + effect for effect in effects])
    for changed in (known.without(effects), known.forgetting(effects)):
        assert (changed.expected[others] == known.expected[others]).all()
        both = np.ix_(others, others)
        assert (changed.covariance[both] == known.covariance[both]).all()


@given(SEEDS, SUBSETS)
def test_forgetting_widens_and_tells_nothing_of_the_others(seed, effects):
    known = told(seed)
    forgotten = known.forgetting(effects)
    for effect in effects:
        place = len(FACTORS) + effect
        assert forgotten.covariance[place, place] == pytest.approx(EFFECT_SPREAD[effect] ** 2)
        assert forgotten.covariance[place, place] > known.covariance[place, place]
        assert np.count_nonzero(forgotten.covariance[place]) == 1
        assert np.count_nonzero(forgotten.covariance[:, place]) == 1


@given(SEEDS, st.floats(0.0, 1e5), st.floats(0.0, 1e5))
def test_age_never_makes_surer(seed, time, more):
    known = told(seed)
    aged, older = known.aged(time), known.aged(time + more)
    assert (aged.expected == known.expected).all()
    assert widens(aged, known)
    assert widens(older, aged)


def test_knowledge_of_no_age_is_doubted_and_time_does_not_run_backward():
    known = told(1)
    assert (np.diag(known.aged(0.0).covariance) > np.diag(known.covariance)).all()
    assert (known.aged(-5.0).covariance == known.aged(0.0).covariance).all()


def test_constants_walk_with_the_square_root_of_time():
    known = told(2)
    start = np.diag(known.aged(0.0).covariance)
    hour, four = (np.diag(known.aged(time).covariance) - start for time in (3600.0, 14400.0))
    assert np.sqrt(four) == pytest.approx(2.0 * np.sqrt(hour), rel=1e-6)
    assert (hour > 0.0).all()


@given(SEEDS, SUBSETS)
def test_the_precision_is_the_inverse_however_different_the_units_are(seed, absent):
    known = told(seed).without(absent)
    identity = known.precision() @ known.covariance
    # In units in which each constant is of its own size.
    scale = np.sqrt(np.diag(known.covariance))
    assert identity * np.outer(scale, 1.0 / scale) == pytest.approx(np.eye(COUNT), abs=1e-8)
    assert known.precision() == pytest.approx(known.precision().T, rel=1e-6)


def test_an_effect_left_out_says_nothing_about_the_rest():
    known = told(3).without({0, 2})
    precision = known.precision()
    for effect in (0, 2):
        place = len(FACTORS) + effect
        assert np.count_nonzero(precision[place]) == 1
        assert math.isfinite(precision[place, place])
