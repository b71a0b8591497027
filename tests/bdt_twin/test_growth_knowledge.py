"""Wear goes on as it did; growth that comes suddenly is a gap that has jumped, until it lasts."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.estimator import Estimate
from bdt_twin.growth_knowledge import LONGEST_JUMP, USUAL, GrowthKnowledge

CHANGE = 3e-4
"""Usual change of growth in a second [rad/s^1.5]."""
UNSURE = 1e-3
"""Standard uncertainty of growth [rad/s]."""


def answer(time, growth, unsure_by=UNSURE):
    return Estimate(time, 0.2, 1e-3, growth=growth, growth_uncertainty=unsure_by)


@pytest.fixture
def steady():
    """Growth that is known to be zero."""
    knowledge = GrowthKnowledge(CHANGE)
    knowledge.learn(answer(10.0, 0.0), 0.0, 0.0)
    return knowledge


def learned(knowledge, time, growth):
    """Take an answer as the estimator does, and return by how much its growth was sudden."""
    sudden = knowledge.sudden(time, growth, UNSURE)
    knowledge.learn(answer(time, growth, math.hypot(UNSURE, sudden)), sudden, 0.0)
    return sudden


@given(growth=st.floats(-10.0, 10.0))
def test_the_first_growth_is_not_sudden(growth):
    assert GrowthKnowledge(CHANGE).sudden(3.0, growth, UNSURE) == 0.0


@given(after=st.floats(0.0, 100.0), sign=st.sampled_from([-1.0, 1.0]))
def test_growth_may_become_what_its_uncertainties_and_usual_change_allow(after, sign):
    knowledge = GrowthKnowledge(CHANGE)
    knowledge.learn(answer(10.0, 0.0), 0.0, 0.0)
    usual = USUAL * math.sqrt(2.0 * UNSURE**2 + CHANGE**2 * after)
    sudden = [
        knowledge.sudden(10.0 + after, sign * times * usual, UNSURE) for times in (0.99, 1.01, 3.0)
    ]
    assert sudden == pytest.approx([0.0, 1.01 * usual, 3.0 * usual])


def test_a_jump_does_not_become_the_growth_that_is_known(steady):
    """Windows tell it again and again as long as it is in the data that tell growth."""
    assert learned(steady, 12.0, 0.03) == pytest.approx(0.03)
    assert learned(steady, 14.0, 0.02) == pytest.approx(0.02)
    assert learned(steady, 20.0, 0.0) == 0.0


def test_growth_that_ends_is_no_jump():
    knowledge = GrowthKnowledge(CHANGE)
    knowledge.learn(answer(10.0, 0.03), 0.0, 0.0)
    assert learned(knowledge, 12.0, 0.0) == 0.0
    assert learned(knowledge, 14.0, -0.03) == pytest.approx(0.03)


def test_growth_that_lasts_is_known_at_last(steady):
    assert learned(steady, 12.0, 0.03) > 0.0
    assert learned(steady, 12.0 + 0.9 * LONGEST_JUMP, 0.03) > 0.0
    assert learned(steady, 12.0 + 1.1 * LONGEST_JUMP, 0.03) > 0.0
    assert learned(steady, 12.0 + 1.5 * LONGEST_JUMP, 0.03) == 0.0


def test_one_jump_after_the_other_is_each_a_jump(steady):
    assert learned(steady, 12.0, 0.03) > 0.0
    assert learned(steady, 18.0, 0.0) == 0.0
    assert learned(steady, 19.0, 0.03) > 0.0
    assert learned(steady, 24.0, 0.03) > 0.0, "no more than 6 s after the second one"


def test_a_gap_that_rises_and_falls_makes_other_growth_usual(steady):
    assert steady.change == CHANGE
    assert steady.sudden(14.0, 0.01, UNSURE) > 0.0
    steady.learn(answer(12.0, 0.0), 0.0, 10.0 * CHANGE)
    assert steady.change == 10.0 * CHANGE
    assert steady.sudden(14.0, 0.01, UNSURE) == 0.0
    steady.learn(answer(13.0, 0.0), 0.0, 0.1 * CHANGE)
    assert steady.change == CHANGE
