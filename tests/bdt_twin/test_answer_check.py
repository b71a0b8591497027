"""Which gaps are stated: those that are sure, agree with what was known, and are confirmed."""

import math

import pytest

from bdt_twin.answer_check import (
    CONTRADICTION,
    DOUBTFUL,
    FIRST_SHARE,
    LESS_EXPLAINED,
    LONG_AFTER,
    MOST_PUSHED,
    SUDDEN_RISE,
    SUDDEN_WALK,
    AnswerCheck,
)
from bdt_twin.gap_knowledge import SAME_REVERSAL
from bdt_twin.innovations import NoiseLevels
from bdt_twin.noise_levels import HARDLY_EXPLAINED, NOTHING

LARGEST = math.radians(1.0)
SURE, UNSURE = 0.5 * LARGEST, 1.1 * LARGEST
KNOWN = math.radians(5.0), math.radians(0.1)
EXPLAINED = NoiseLevels(1e-6, 0.9 * HARDLY_EXPLAINED * 1e-6, 1e-6, 0.0)
HARDLY = NoiseLevels(1e-6, 1e-6, 1.1 * HARDLY_EXPLAINED * 1e-6, 0.0)


def doubt(check, *gap, **more):
    return whole_doubt(check, *gap, **more).reason


def whole_doubt(
    check, gap=KNOWN[0], uncertainty=SURE, expected=KNOWN, levels=EXPLAINED, **happened
):
    happened = {"at": 0.0, "pushed": 0.0, "is_surprised": False, "error_ratio": 1.0} | happened
    return check.doubt(gap, uncertainty, expected, levels, **happened)


@pytest.fixture
def check():
    return AnswerCheck(LARGEST)


def test_an_answer_that_is_sure_is_stated(check):
    assert doubt(check) == ""
    assert doubt(check, expected=None) == ""


def test_an_answer_that_is_not_sure_is_not_and_says_by_how_much(check):
    assert doubt(check, uncertainty=UNSURE) == "the gap remains unknown by 1.1 deg"


def test_the_first_answer_of_a_machine_that_is_hardly_explained_waits_for_the_second(check):
    assert "confirm" in doubt(check, levels=HARDLY, expected=None)
    assert doubt(check, levels=HARDLY, expected=None) == ""
    assert doubt(check, levels=HARDLY) == ""


def test_a_motor_that_walks_a_lot_at_once_gives_a_first_answer_again(check):
    """Its gap may have jumped, which a walk explains as well as the gap that it was."""
    slight = NoiseLevels(1e-6, slow=2.0 * NOTHING * 1e-6)
    for before, confirmed in ((NoiseLevels(1e-6), False), (slight, True), (EXPLAINED, True)):
        assert doubt(check, levels=before) == ""
        assert doubt(check, levels=HARDLY).startswith("the next window") != confirmed
        assert doubt(check, levels=HARDLY) == ""


def test_where_a_machine_is_hardly_explained_answers_begin_surer_than_they_go_on(check):
    begins, goes_on = 0.99 * FIRST_SHARE * LARGEST, 0.99 * LARGEST
    doubt(check, uncertainty=begins, levels=HARDLY)
    assert "unknown by 0.99 deg" in doubt(check, uncertainty=goes_on, levels=HARDLY)
    assert doubt(check, uncertainty=begins, levels=HARDLY) == ""
    assert doubt(check, uncertainty=goes_on, levels=HARDLY) == ""
    assert "newest" in doubt(check, levels=HARDLY, is_surprised=True)
    assert "unknown by" in doubt(check, uncertainty=goes_on, levels=HARDLY)


def walking(ratio):
    return NoiseLevels(1e-6, slow=ratio * 1e-6)


def test_a_sudden_walk_may_hide_a_jump_also_where_the_gap_agrees_with_what_was_known(check):
    """A walk of 75 times the noise explained a gap as it was before it jumped by 8 deg."""
    walk, usual = 1.01 * SUDDEN_WALK, 0.99 * SUDDEN_WALK / SUDDEN_RISE
    assert doubt(check, levels=walking(usual)) == ""
    for at in (1.0, 1.0, 0.5, 0.99 * LONG_AFTER):
        assert "sudden walk" in doubt(check, at=at, levels=walking(walk))
    assert "sudden walk" in doubt(check, at=1.0, levels=walking(1.01 * usual)), "still more"
    assert doubt(check, at=1.01 * (1.0 + LONG_AFTER), levels=walking(walk)) == "", "wear as well"
    assert doubt(check, at=5.0, levels=walking(SUDDEN_RISE * walk)) == "", "as usual by now"


def test_a_sudden_walk_does_not_hide_a_jump_that_two_reversals_tell(check):
    walk, jumped = walking(2.0 * SUDDEN_WALK), 2.0 * KNOWN[0]
    assert doubt(check, levels=walking(1.0)) == ""
    assert "contradicts" in doubt(check, jumped, at=1.0, levels=walk)
    assert "sudden walk" in doubt(check, at=1.5, levels=walk), "is no sign that it has not jumped"
    assert doubt(check, jumped, at=2.0, levels=walk, uncertainty=0.9 * LARGEST) == ""


@pytest.mark.parametrize(
    ("usual", "walk", "uncertainty"),
    [
        (1.0, 0.99 * SUDDEN_WALK, SURE),
        (1.01 * SUDDEN_WALK / SUDDEN_RISE, SUDDEN_WALK, SURE),
        (1.0, 2.0 * SUDDEN_WALK, 0.99 * DOUBTFUL),
    ],
)
def test_a_walk_that_is_slight_or_usual_or_leaves_the_gap_sure_hides_none(
    check, usual, walk, uncertainty
):
    assert doubt(check, levels=walking(usual)) == ""
    assert doubt(check, uncertainty=uncertainty, levels=walking(walk)) == ""


def test_a_sudden_walk_that_ends_costs_no_further_answer(check):
    assert doubt(check, levels=walking(1.0)) == ""
    assert "sudden walk" in doubt(check, at=1.0, levels=walking(2.0 * SUDDEN_WALK))
    assert doubt(check, at=2.0, levels=walking(1.0)) == ""


@pytest.mark.parametrize("expected", [None, KNOWN])
def test_what_pushes_too_often_is_no_push_and_leaves_at_most_a_rough_gap(check, expected):
    assert doubt(check, expected=expected, pushed=0.99 * MOST_PUSHED) == ""
    often = whole_doubt(check, expected=expected, pushed=0.03)
    assert often.reason == "something holds or pushes the platforms for 3 % of the time"
    assert often.is_rough == (expected is None)


def test_where_it_is_explained_they_begin_as_they_go_on(check):
    assert doubt(check, uncertainty=0.99 * LARGEST, expected=None) == ""


@pytest.mark.parametrize("interruption", ["unsure", "unexplained"])
def test_each_answer_after_silence_is_a_first_one(check, interruption):
    for _ in range(2):
        doubt(check, levels=HARDLY)
    if interruption == "unsure":
        assert doubt(check, uncertainty=UNSURE, levels=HARDLY)
    else:
        check.unexplained()
    assert "confirm" in doubt(check, levels=HARDLY)
    assert doubt(check, levels=HARDLY) == ""


def test_where_the_model_explains_the_machine_silence_costs_no_answer(check):
    check.unexplained()
    assert doubt(check, levels=EXPLAINED) == ""


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_an_answer_far_from_what_was_known_is_stated_when_another_reversal_repeats_it(check, side):
    allowed = CONTRADICTION * math.hypot(SURE, KNOWN[1])
    assert doubt(check, KNOWN[0] + side * 0.99 * allowed) == ""
    assert "contradicts" in doubt(check, KNOWN[0] + side * 1.01 * allowed)
    assert doubt(check, KNOWN[0] + side * 1.01 * allowed, at=1.01 * SAME_REVERSAL) == ""


def test_windows_that_share_a_reversal_say_it_once(check):
    """Of two gaps that explain a reversal all its windows may choose the same wrong one."""
    for fitted_again in (0.0, 0.3, 0.6, 0.9):
        told = fitted_again * SAME_REVERSAL
        assert "contradicts" in doubt(check, 2.0 * KNOWN[0], at=told)
    assert doubt(check, 2.0 * KNOWN[0], at=1.01 * SAME_REVERSAL) == ""


def test_a_window_that_is_explained_less_well_overturns_nothing_for_a_while(check):
    """Of a fit that is still on its way to a gap that has jumped, other reversals say it too."""
    less = {"error_ratio": 1.01 * LESS_EXPLAINED}
    for at in (0.0, 1.0, 0.99 * LONG_AFTER):
        assert "contradicts" in doubt(check, 2.0 * KNOWN[0], at=at, **less)
    assert doubt(check, 2.0 * KNOWN[0], at=1.01 * LONG_AFTER, **less) == ""
    assert "contradicts" in doubt(check, 2.0 * KNOWN[0], at=6.0, **less)
    assert doubt(check, 2.0 * KNOWN[0], at=7.0, error_ratio=0.99 * LESS_EXPLAINED) == ""
    assert doubt(check, **less) == "", "what agrees is stated"


def test_one_that_is_very_sure_needs_another_reversal_and_no_more(check):
    less = {"error_ratio": 1.01 * LESS_EXPLAINED, "uncertainty": 0.99 * DOUBTFUL, "pushed": 1e-3}
    assert "contradicts" in doubt(check, 2.0 * KNOWN[0], at=0.0, **less)
    assert doubt(check, 2.0 * KNOWN[0], at=1.01 * SAME_REVERSAL, **less) == ""


def test_an_answer_that_is_very_sure_contradicts_only_where_something_was_pushed(check):
    very_sure = 0.99 * DOUBTFUL
    assert doubt(check, 2.0 * KNOWN[0], very_sure) == ""
    assert "contradicts" in doubt(check, 2.0 * KNOWN[0], very_sure, pushed=0.001)


def test_an_answer_that_leaves_the_newest_data_unexplained_is_not_stated(check):
    assert "newest" in doubt(check, is_surprised=True)
    assert "newest" in doubt(check, is_surprised=True, expected=None)
    assert doubt(check) == ""


def test_what_contradicts_has_to_be_repeated_not_to_be_another_contradiction(check):
    assert "newest" in doubt(check, 2.0 * KNOWN[0], at=0.0, is_surprised=True)
    assert "contradicts" in doubt(check, 0.5 * KNOWN[0], at=1.0)
    assert "contradicts" in doubt(check, 2.0 * KNOWN[0], at=2.0)
    # Nearer to the contradiction than to what was known before: the gap may grow meanwhile.
    assert doubt(check, 2.2 * KNOWN[0], at=3.0) == ""
    assert "contradicts" in doubt(check, 2.0 * KNOWN[0], at=4.0)
    # What was known before may turn out to be right as well.
    assert doubt(check, at=5.0) == ""
    assert "contradicts" in doubt(check, 2.2 * KNOWN[0], at=6.0)


def test_a_gap_is_a_bound_all_the_same_where_it_is_only_not_sure_enough(check):
    assert whole_doubt(check, uncertainty=UNSURE).is_rough
    assert not whole_doubt(check, uncertainty=UNSURE, is_surprised=True).is_rough
    assert not whole_doubt(check, 2.0 * KNOWN[0]).is_rough
    assert not whole_doubt(check).is_rough
    check.unexplained()
    assert whole_doubt(check, levels=HARDLY, expected=None).is_rough
