"""Which measurements the controller believes, and what it does with the others."""

import pytest

from bdt_controller.plausibility import (
    PlausibilityCheck,
    PlausibilitySettings,
    UnbelievedReadingError,
    Verdict,
)
from bdt_msgs_py.rejection import MessageRejectedError, Reason

PERIOD = 2_000_000
SETTINGS = PlausibilitySettings(
    time_tolerance=0.1, largest_speed=0.5, smallest_change=2e-3, confirmations=4
)


@pytest.fixture
def check():
    check = PlausibilityCheck(SETTINGS, 500.0)
    assert check.check(0, 0.0, 0.0) is Verdict.BEGIN
    return check


def doubts(check, stamp, position, reason=Reason.CHANGE):
    with pytest.raises(UnbelievedReadingError) as caught:
        check.check(stamp, position, 0.0)
    assert caught.value.reason is reason
    return str(caught.value)


def test_measurements_that_follow_each_other_are_believed(check):
    for step in range(1, 100):
        assert check.check(step * PERIOD, 1e-3 * step, 0.0) is Verdict.ANSWER


def test_a_measurement_that_was_sent_twice_is_answered_twice(check):
    check.check(PERIOD, 1e-3, 0.0)
    assert check.check(PERIOD, 1e-3, 0.0) is Verdict.REPEAT


def test_another_reading_of_a_time_that_was_answered_is_not_believed(check):
    check.check(PERIOD, 1e-3, 0.0)
    doubts(check, PERIOD, 1.1e-3, Reason.REPEATED)
    assert check.check(PERIOD, 1e-3, 0.0) is Verdict.REPEAT


def test_a_jump_is_not_believed_and_the_next_real_reading_is(check):
    text = doubts(check, PERIOD, 0.1)
    assert text == "position 0.1 m, 0.002 s after one of 0 m: must not change faster than 0.5 m/s"
    assert check.check(PERIOD, 1e-3, 0.0) is Verdict.ANSWER


def test_what_is_too_far_for_one_period_may_be_right_after_some(check):
    doubts(check, PERIOD, 0.01)
    assert check.check(10 * PERIOD, 0.01, 0.0) is Verdict.ANSWER


def test_a_jump_that_stays_is_believed_after_the_confirmations(check):
    for step in range(1, 4):
        doubts(check, step * PERIOD, 0.1 + 1e-4 * step)
    assert check.check(4 * PERIOD, 0.1, 0.0) is Verdict.ANSWER
    assert check.check(5 * PERIOD, 0.1, 0.0) is Verdict.ANSWER


def test_jumps_to_and_fro_confirm_nothing(check):
    for step in range(1, 20):
        doubts(check, step * PERIOD, 0.1 * (-1) ** step)


def test_one_stray_reading_sent_again_and_again_confirms_nothing(check):
    for _ in range(20):
        doubts(check, 10 * PERIOD, 0.1)


def test_a_time_from_elsewhere_gets_no_answer(check):
    with pytest.raises(MessageRejectedError) as caught:
        check.check(10**9, 0.0, 0.0)
    assert not isinstance(caught.value, UnbelievedReadingError)
    assert caught.value.reason is Reason.TIME
    assert check.check(PERIOD, 0.0, 0.0) is Verdict.ANSWER


def test_at_low_rates_the_tolerance_covers_some_periods():
    check = PlausibilityCheck(SETTINGS, 1.0)
    check.check(0, 0.0, 0.0)
    assert check.check(10**9, 0.0, 0.0) is Verdict.ANSWER
    assert check.check(4 * 10**9, 0.0, 0.0) is Verdict.ANSWER


def test_after_a_restart_the_first_reading_may_be_anywhere(check):
    for step in range(1, 100):
        check.check(step * PERIOD, 0.0, 0.0)
    check.expect_restart()
    assert check.check(0, 0.5, 0.0) is Verdict.BEGIN


@pytest.mark.parametrize(
    ("position", "stamp", "reason"),
    [(0.06, 0, Reason.RANGE), (-0.06, 0, Reason.RANGE), (0.01, 2 * 10**8, Reason.TIME)],
)
def test_a_reference_beyond_the_travel_or_in_the_future_is_refused(position, stamp, reason):
    with pytest.raises(MessageRejectedError) as caught:
        SETTINGS.check_reference(position, stamp, 0)
    assert caught.value.reason is reason


def test_a_reference_from_before_holds():
    SETTINGS.check_reference(0.05, 0, 10**12)
    SETTINGS.check_reference(0.05, 10**12, -1)
