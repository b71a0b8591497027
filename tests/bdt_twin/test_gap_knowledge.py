"""Between two answers the surest of what is known counts, and it becomes less sure with time."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.estimator import Estimate
from bdt_twin.gap_knowledge import (
    ROUGHEST,
    SAME_REVERSAL,
    SHARE_OF_DIFFERENCE,
    SURER,
    GapKnowledge,
)

LARGEST = math.radians(1.0)
CHANGE = math.radians(0.02)
"""Change of growth in a second [rad/s^1.5]."""


def known_at(time, degrees, unsure_by, **more):
    return Estimate(time, math.radians(degrees), math.radians(unsure_by), **more)


def held(knowledge, time):
    return knowledge.held(time, "the motor does not move", CHANGE)


@pytest.fixture
def knowledge():
    return GapKnowledge(LARGEST)


def test_at_first_nothing_is_known(knowledge):
    estimate = held(knowledge, 3.0)
    assert not estimate.is_known
    assert (estimate.time, estimate.uncertainty) == (3.0, math.inf)
    assert knowledge.expected(3.0, CHANGE) is None


def test_a_gap_that_is_no_answer_is_held_with_the_reason(knowledge):
    knowledge.learn_roughly(known_at(3.0, 10.0, 4.0), CHANGE)
    estimate = held(knowledge, 3.0)
    assert (estimate.gap, estimate.uncertainty) == pytest.approx(
        (math.radians(10.0), math.radians(4.0))
    )
    assert estimate.reason == "the motor does not move"


def test_what_nothing_has_confirmed_is_no_surer_than_an_answer_may_be(knowledge):
    knowledge.learn_roughly(known_at(3.0, 10.0, 0.3), CHANGE)
    assert held(knowledge, 3.0).uncertainty == pytest.approx(LARGEST)


def test_a_gap_that_could_be_anything_is_not_held(knowledge):
    knowledge.learn_roughly(known_at(3.0, 10.0, 1.01 * ROUGHEST), CHANGE)
    assert not held(knowledge, 3.0).is_known


def test_nothing_that_is_no_answer_contradicts_one(knowledge):
    knowledge.learn_roughly(known_at(3.0, 10.0, 2.0), CHANGE)
    assert knowledge.expected(3.0, CHANGE) is None


def test_an_answer_is_held_until_a_rough_gap_is_surer(knowledge):
    knowledge.learn(known_at(0.0, 5.0, 0.1, growth_uncertainty=math.radians(0.2)))
    knowledge.learn_roughly(known_at(5.0, 7.0, 2.0), CHANGE)
    assert held(knowledge, 5.0).gap == math.radians(5.0)
    knowledge.learn_roughly(known_at(30.0, 15.0, 2.0), CHANGE)
    assert held(knowledge, 30.0).gap == math.radians(15.0)
    gap, _ = knowledge.expected(30.0, CHANGE)
    assert gap == math.radians(5.0)


def test_an_answer_ends_what_was_known_roughly(knowledge):
    knowledge.learn_roughly(known_at(3.0, 10.0, 1.0), CHANGE)
    knowledge.learn(known_at(4.0, 5.0, 0.9, growth_uncertainty=math.radians(1.0)))
    assert held(knowledge, 60.0).gap == math.radians(5.0)


FIRST = known_at(3.0, 5.0, 0.1, growth=0.01, growth_uncertainty=1e-3, age=0.5)


def second(later, unsure_by, degrees=5.4):
    """Return the answer of a window that ends a second after that of ``FIRST``."""
    return known_at(
        FIRST.time + later,
        degrees,
        unsure_by,
        growth=0.02,
        age=1.5 - later,
        voltage_offset=0.02,
        voltage_offset_uncertainty=0.001,
    )


def test_an_answer_at_another_reversal_is_stated_as_it_is(knowledge):
    assert knowledge.learn(FIRST) == FIRST
    another = second(1.1 * SAME_REVERSAL, 0.5)
    assert knowledge.learn(another) == another


@pytest.mark.parametrize("later", [0.9 * SAME_REVERSAL, -0.9 * SAME_REVERSAL, -2.0])
@pytest.mark.parametrize("unsure_by", [0.09, 0.1, 0.5])
def test_an_answer_at_the_same_reversal_or_before_it_is_that_before(knowledge, later, unsure_by):
    knowledge.learn(FIRST)
    stated = knowledge.learn(second(later, unsure_by))
    # The gap is that of the window that had more data; all else is of the newest one.
    assert (stated.time, stated.gap, stated.growth) == (FIRST.time, FIRST.gap, FIRST.growth)
    assert stated.growth_uncertainty == FIRST.growth_uncertainty
    assert stated.time + stated.age == pytest.approx(FIRST.time + FIRST.age + 1.0)
    assert (stated.voltage_offset, stated.voltage_offset_uncertainty) == (0.02, 0.001)
    assert knowledge.expected(3.0, CHANGE)[0] == FIRST.gap


def test_one_that_is_surer_takes_its_place(knowledge):
    knowledge.learn(FIRST)
    surer = second(0.0, 0.99 * 0.1 / SURER)
    stated = knowledge.learn(surer)
    assert (stated.gap, stated.growth) == (surer.gap, surer.growth)


@pytest.mark.parametrize("unsure_by", [0.05, 0.5])
def test_answers_at_the_same_reversal_that_differ_are_both_less_sure(knowledge, unsure_by):
    knowledge.learn(FIRST)
    stated = knowledge.learn(second(0.0, unsure_by))
    surest = math.radians(min(unsure_by, 0.1))
    doubt = SHARE_OF_DIFFERENCE * math.radians(0.4)
    assert stated.uncertainty == pytest.approx(math.hypot(surest, doubt))
    assert knowledge.expected(stated.time, CHANGE)[1] == stated.uncertainty, "from then on"


def test_a_rough_gap_leaves_what_is_known_of_the_amplifier(knowledge):
    offset = {"voltage_offset": 0.02, "voltage_offset_uncertainty": 0.001}
    knowledge.learn(known_at(0.0, 5.0, 0.1, growth_uncertainty=math.radians(1.0), **offset))
    knowledge.learn_roughly(known_at(30.0, 15.0, 2.0), CHANGE)
    assert held(knowledge, 30.0).gap == math.radians(15.0)
    assert held(knowledge, 30.0).compensation == -0.02


@given(
    unsure=st.floats(0.0, ROUGHEST),
    growth=st.floats(-1.0, 1.0),
    ages=st.lists(st.floats(0.0, 1e3), min_size=2, max_size=2).map(sorted),
)
def test_what_is_held_becomes_less_sure(unsure, growth, ages):
    knowledge = GapKnowledge(LARGEST)
    knowledge.learn_roughly(known_at(1.0, 10.0, unsure, growth=math.radians(growth)), CHANGE)
    before, after = (held(knowledge, 1.0 + age) for age in ages)
    assert before.uncertainty <= after.uncertainty
    assert after.uncertainty >= abs(math.radians(growth)) * ages[1]
    assert (before.time, after.time) == (1.0, 1.0)
    assert after.age == pytest.approx(ages[1])
