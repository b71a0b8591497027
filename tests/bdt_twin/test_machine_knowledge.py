"""What is known of a machine: how it is forgotten, doubted, and left out."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from bdt_plant.motor import MotorParameters
from bdt_twin.machine_knowledge import (
    CHANGING,
    EFFECT_LIMITS,
    EFFECT_SPREAD,
    EFFECTS,
    FACTOR_SPREAD,
    LONGEST_TREND,
    MachineKnowledge,
    first_knowledge,
)
from bdt_twin.model_factors import FACTORS

SPREAD = np.array([*FACTOR_SPREAD, *EFFECT_SPREAD])
COUNT = len(FACTORS) + len(EFFECTS)
FRICTION, GROWTH = (len(FACTORS) + EFFECTS.index(name) for name in CHANGING)
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
@example(908, set())
def test_absent_effects_stay_whatever_the_data_say_and_the_others_move_as_without_them(
    seed, absent
):
    before = told(seed)
    known = before.without(absent)
    places = [len(FACTORS) + effect for effect in sorted(absent)]
    far, deviations = known.expected + 3.0 * SPREAD, 0.01 * SPREAD
    found = after_data(known, far, deviations)
    assert (np.abs(found - known.expected)[places] < 1e-6 * SPREAD[places]).all()
    others = np.delete(np.arange(COUNT), places)
    covariance = before.covariance[np.ix_(others, others)]
    # As a Kalman filter has it, where the inverse of the covariance is not needed.
    innovated = covariance + np.diag(np.square(deviations[others]))
    moved = covariance @ np.linalg.solve(innovated, far[others] - before.expected[others])
    assert found[others] - before.expected[others] == pytest.approx(
        moved, rel=1e-6, abs=1e-6 * SPREAD.min()
    )


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


def as_changing(known, growth):
    """Return the knowledge with 0.2 V of friction that grows by a share in each second."""
    expected = known.expected.copy()
    expected[[FRICTION, GROWTH]] = 0.2, growth
    return known._replace(expected=expected)


@given(SEEDS, st.floats(-0.01, 0.01), st.floats(0.0, LONGEST_TREND))
def test_friction_that_was_changing_goes_on_and_its_doubt_with_it(seed, growth, time):
    known = as_changing(told(seed), growth)
    later = known.projected(time)
    slopes = np.eye(COUNT)
    slopes[FRICTION, [FRICTION, GROWTH]] = 1.0 + growth * time, 0.2 * time
    assert later.expected[FRICTION] == pytest.approx(0.2 * (1.0 + growth * time))
    assert (np.delete(later.expected, FRICTION) == np.delete(known.expected, FRICTION)).all()
    expected = slopes @ known.covariance @ slopes.T
    scale = np.sqrt(np.diag(expected))
    assert later.covariance / np.outer(scale, scale) == pytest.approx(
        expected / np.outer(scale, scale), abs=1e-9
    )


def test_friction_changes_no_further_than_anybody_has_seen_and_never_to_less_than_none():
    known = as_changing(told(4), -0.1)
    assert known.projected(1e6).expected[FRICTION] == 0.0
    for one, other in zip(known.projected(1e6), known.projected(LONGEST_TREND), strict=True):
        assert (one == other).all()
    for one, other in zip(known.projected(-1.0), known, strict=True):
        assert (one == other).all()


@given(SEEDS, st.floats(-0.1, 0.0))
def test_friction_that_comes_to_nothing_is_not_known_exactly(seed, growth):
    """Its change alone told it: a covariance that has no inverse, and a fit that was no number."""
    known = as_changing(told(seed), growth).projected(LONGEST_TREND)
    spread = np.sqrt(np.diag(known.covariance))
    correlations = known.covariance / np.outer(spread, spread)
    assert abs(correlations[FRICTION, GROWTH]) < 1.0 - 1e-6
    precision = known.precision() * np.outer(spread, spread)
    assert precision @ correlations == pytest.approx(np.eye(COUNT), abs=1e-6)


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
