"""Evidence for one kind of friction or the other, as windows add to it."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_twin.friction_evidence import (
    ALIKE,
    BELIEVED,
    CERTAIN,
    DIFFERENCE_DOUBT,
    EXPLAINED_GAIN,
    LARGE_ANGLE,
    MOST_GAIN,
    UNFINISHED,
    FrictionEvidence,
    are_alike,
)

DIFFERENCE = math.radians(0.5)
FULL = math.ceil(BELIEVED / MOST_GAIN)
"""Comparisons that suffice where each gains a lot."""
gains = st.floats(-2.0 * UNFINISHED, 1e6)


def told(*comparisons):
    """Return the evidence after comparisons, each with its gain and angle."""
    evidence = FrictionEvidence()
    for gain, angle in comparisons:
        evidence.compared(gain, DIFFERENCE, angle)
    return evidence


def certain():
    evidence = FrictionEvidence()
    for _ in range(math.ceil(CERTAIN / EXPLAINED_GAIN)):
        evidence.explained()
    return evidence


def test_at_first_nothing_is_certain_and_nothing_believed():
    evidence = FrictionEvidence()
    assert not evidence.is_certain
    assert not evidence.is_against
    assert evidence.openness == 1.0
    assert evidence.doubt == 0.0, "no gap with other friction is known"


@pytest.mark.parametrize("angle", [LARGE_ANGLE, 3.0 * LARGE_ANGLE, None])
def test_the_other_friction_is_believed_once_gains_add_up(angle):
    assert not told(*[(1e6, angle)] * (FULL - 1)).is_against
    assert told(*[(1e6, angle)] * FULL).is_against
    assert not told(*[(0.3 * MOST_GAIN, angle)] * (2 * FULL)).is_against


def test_gains_by_a_small_yield_angle_count_less():
    half = [(1e6, 0.5 * LARGE_ANGLE)]
    assert not told(*half * (2 * FULL - 2)).is_against
    assert told(*half * (2 * FULL)).is_against


def test_gains_by_one_angle_now_and_another_one_then_do_not_add_up():
    other = 1.1 * ALIKE * LARGE_ANGLE
    assert not told(*[(1e6, LARGE_ANGLE), (1e6, other)] * FULL).is_against
    assert told((1e6, LARGE_ANGLE), *[(1e6, other)] * FULL).is_against, "it is later, if they do"


def test_rigid_friction_has_no_angle_that_may_differ():
    assert told(*[(1e6, None)] * FULL).is_against


def test_a_fit_that_has_not_come_to_its_end_tells_nothing():
    before = told(*[(1e6, LARGE_ANGLE)] * (FULL - 1))
    before.compared(-1.1 * UNFINISHED, 9.0, 9.0)
    assert before.doubt == pytest.approx(DIFFERENCE_DOUBT * DIFFERENCE)
    before.compared(1e6, DIFFERENCE, LARGE_ANGLE)
    assert before.is_against


def test_windows_that_are_explained_make_the_friction_certain():
    evidence = certain()
    assert evidence.is_certain
    assert evidence.openness == evidence.doubt == 0.0
    evidence.compared(1e6, DIFFERENCE, LARGE_ANGLE)
    assert not evidence.is_certain
    assert evidence.doubt == pytest.approx(DIFFERENCE_DOUBT * MOST_GAIN / CERTAIN * DIFFERENCE)


def test_what_has_been_certain_for_long_is_overthrown_as_soon_as_what_just_became_so():
    evidence = certain()
    evidence.explained()
    comparisons = math.ceil((CERTAIN + BELIEVED) / MOST_GAIN)
    for number in range(comparisons):
        assert not evidence.is_against, number
        evidence.compared(1e6, DIFFERENCE, LARGE_ANGLE)
    assert evidence.is_against


def test_losses_speak_for_the_friction_of_the_machine():
    evidence = told(*[(-0.5 * UNFINISHED, LARGE_ANGLE)] * math.ceil(CERTAIN / MOST_GAIN))
    assert evidence.is_certain
    assert evidence.doubt == 0.0


def test_once_the_friction_is_another_one_it_is_in_doubt_again():
    evidence = told(*[(1e6, LARGE_ANGLE)] * FULL)
    evidence.turn()
    assert not evidence.is_against
    assert evidence.doubt == pytest.approx(DIFFERENCE_DOUBT * DIFFERENCE)


@given(st.lists(st.tuples(gains, st.floats(1e-4, 0.1) | st.none()), max_size=30))
def test_a_gap_is_never_less_sure_than_the_difference_of_both(comparisons):
    evidence = told(*comparisons)
    assert 0.0 <= evidence.openness <= 1.0
    assert 0.0 <= evidence.doubt <= DIFFERENCE_DOUBT * DIFFERENCE


@given(st.lists(gains, max_size=30), st.floats(1e-4, 0.1))
def test_no_single_window_decides(before, angle):
    evidence = told(*[(gain, angle) for gain in before])
    if not evidence.is_against:
        evidence.turn()
        evidence.compared(1e9, DIFFERENCE, angle)
        assert not evidence.is_against


def test_angles_are_alike_whichever_comes_first():
    assert are_alike([1.0, 0.99 * ALIKE], ALIKE)
    assert are_alike([0.99 * ALIKE, 1.0, 1.2], ALIKE)
    assert not are_alike([1.0, 1.01 * ALIKE], ALIKE)
