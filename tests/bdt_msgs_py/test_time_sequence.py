"""Times that continue a sequence, and strays."""

import pytest

from bdt_msgs_py.rejection import MessageRejectedError, Reason
from bdt_msgs_py.time_sequence import SILENCE, Step, TimeSequence

SECOND = 1_000_000_000


@pytest.fixture
def sequence():
    sequence = TimeSequence(SECOND, 3)
    assert sequence.check(10 * SECOND, 0.0) is Step.BEGINS
    return sequence


def is_rejected(sequence, time, now=100.0):
    with pytest.raises(MessageRejectedError) as caught:
        sequence.check(time, now)
    assert caught.value.reason is Reason.TIME
    return str(caught.value)


def test_a_step_forward_up_to_the_tolerance_continues(sequence):
    assert sequence.check(11 * SECOND, 0.0) is Step.CONTINUES
    assert sequence.check(11 * SECOND + 1, 0.0) is Step.CONTINUES
    assert sequence.check(11 * SECOND + 1, 0.0) is Step.REPEATS


@pytest.mark.parametrize("time", [0, 10 * SECOND - 1, 12 * SECOND, (2**31 - 1) * SECOND])
def test_a_single_time_elsewhere_is_rejected_however_often_the_sequence_goes_on(sequence, time):
    for step in range(1, 10):
        is_rejected(sequence, time)
        assert sequence.check(10 * SECOND + step, 100.0) in {Step.CONTINUES, Step.REPEATS}


def test_a_rejection_names_both_times_and_what_is_allowed(sequence):
    assert is_rejected(sequence, 12 * SECOND) == (
        "time 12 s: is 2 s after the newest accepted, must be 0 to 1 s after it"
    )
    assert "is 10 s before the newest accepted" in is_rejected(sequence, 0)


def test_times_in_a_row_after_a_silence_are_where_the_source_has_gone(sequence):
    is_rejected(sequence, 50 * SECOND)
    is_rejected(sequence, 50 * SECOND + 1)
    assert sequence.check(50 * SECOND + 2, 100.0) is Step.CONTINUES


def test_times_that_go_back_for_good_begin_another_run(sequence):
    is_rejected(sequence, 0)
    is_rejected(sequence, 0)
    assert sequence.check(0, 100.0) is Step.BEGINS


def test_without_a_silence_nothing_takes_the_place_of_a_source(sequence):
    for step in range(10):
        is_rejected(sequence, step, now=0.99 * SILENCE)


def test_strays_that_do_not_continue_each_other_confirm_nothing(sequence):
    for time in (50, 90, 70, 20, 60, 40):
        is_rejected(sequence, time * SECOND)


def test_a_clock_that_went_back_speaks_for_the_first_time_that_did(sequence):
    sequence.expect_restart()
    assert sequence.check(0, 0.0) is Step.BEGINS


def test_a_clock_that_went_back_is_forgotten_when_the_sequence_goes_on(sequence):
    sequence.expect_restart()
    sequence.check(10 * SECOND + 1, 0.0)
    is_rejected(sequence, 0)


def test_a_clock_that_went_back_does_not_speak_for_the_future(sequence):
    sequence.expect_restart()
    is_rejected(sequence, 20 * SECOND)


def test_after_a_stray_from_near_by_the_sequence_goes_on_below_it(sequence):
    sequence.check(10 * SECOND + 1, 0.0)
    assert sequence.check(10 * SECOND + 500, 0.0) is Step.CONTINUES
    for step in range(2, 9):
        assert sequence.check(10 * SECOND + step, 0.0) is Step.CONTINUES
    is_rejected(sequence, 10 * SECOND + 1)
