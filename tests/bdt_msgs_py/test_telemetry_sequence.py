"""Batches of telemetry that continue a run, and strays."""

import numpy as np
import pytest

from bdt_msgs_py.rejection import MessageRejectedError, Reason
from bdt_msgs_py.telemetry_sequence import Admitted, TelemetrySequence
from bdt_msgs_py.time_sequence import SILENCE

STEP = 2e-4


def batch(begin, count=500, step=STEP):
    rows = np.zeros((count, 3))
    rows[:, 0] = begin + step * np.arange(count)
    return rows


@pytest.fixture
def sequence():
    sequence = TelemetrySequence()
    assert len(sequence.admit(batch(10.0), 0.0).batches) == 1
    return sequence


def is_rejected(sequence, rows, now=100.0, reason=Reason.TIME):
    with pytest.raises(MessageRejectedError) as caught:
        sequence.admit(rows, now)
    assert caught.value.reason is reason
    return str(caught.value)


def begins(admitted):
    return [float(rows[0, 0]) for rows in admitted.batches]


def test_a_batch_that_begins_where_the_last_one_ended_is_admitted(sequence):
    admitted = sequence.admit(batch(10.1), 0.0)
    assert (begins(admitted), admitted.begins, admitted.stray) == ([10.1], False, None)


@pytest.mark.parametrize("begin", [0.0, 10.0, 10.05, 12.0, 2e9])
def test_a_batch_from_elsewhere_is_rejected_however_often_the_run_goes_on(sequence, begin):
    for number in range(1, 10):
        is_rejected(sequence, batch(begin))
        sequence.admit(batch(10.0 + 0.1 * number), 100.0)


@pytest.mark.parametrize("begin", [10.2, 11.0])
def test_behind_a_hole_a_batch_is_held_back_until_the_next_one_continues_it(sequence, begin):
    assert sequence.admit(batch(begin), 100.0) == Admitted([])
    admitted = sequence.admit(batch(begin + 0.1), 100.0)
    assert (begins(admitted), admitted.begins, admitted.stray) == (
        [begin, begin + 0.1],
        False,
        None,
    )


# A plant that waits has run ahead by a second: its newest batch begins a sample later.
@pytest.mark.parametrize("begin", [10.2, 11.1])
def test_behind_a_hole_a_batch_that_comes_again_is_the_newest_one_of_a_plant_that_waits(
    sequence, begin
):
    assert sequence.admit(batch(begin), 100.0) == Admitted([])
    # At once it is the same message twice, which tells nothing.
    assert sequence.admit(batch(begin), 100.0 + 0.9 * SILENCE) == Admitted([])
    assert begins(sequence.admit(batch(begin), 100.0 + 1.1 * SILENCE)) == [begin]
    assert begins(sequence.admit(batch(begin + 0.1), 101.0)) == [begin + 0.1]


@pytest.mark.parametrize("begin", [9.0, 12.0])
def test_a_batch_from_elsewhere_stays_rejected_however_often_it_comes(sequence, begin):
    for number in range(5):
        is_rejected(sequence, batch(begin), 100.0 + number)


def test_a_batch_that_is_held_back_is_a_stray_when_the_run_goes_on_before_it(sequence):
    sequence.admit(batch(10.5), 100.0)
    admitted = sequence.admit(batch(10.1), 100.0)
    assert begins(admitted) == [10.1]
    assert admitted.stray.reason is Reason.TIME
    assert sequence.admit(batch(10.2), 100.0).stray is None


def test_a_batch_that_has_overtaken_the_one_before_it_takes_its_place_behind_it(sequence):
    assert sequence.admit(batch(10.2), 0.0) == Admitted([])
    admitted = sequence.admit(batch(10.1), 0.0)
    assert (begins(admitted), admitted.begins, admitted.stray) == ([10.1, 10.2], False, None)
    assert begins(sequence.admit(batch(10.3), 0.0)) == [10.3]


def test_the_first_batch_is_one_of_the_time_that_is_known():
    sequence = TelemetrySequence()
    with pytest.raises(MessageRejectedError, match="batch from 100 s: is far from the time"):
        sequence.admit(batch(100.0), 0.0, expected=0.0)
    assert begins(sequence.admit(batch(0.0), 0.0, expected=0.1)) == [0.0]


def test_two_batches_make_a_first_one_that_nobody_expected():
    sequence = TelemetrySequence()
    with pytest.raises(MessageRejectedError):
        sequence.admit(batch(100.0), 100.0, expected=0.0)
    assert begins(sequence.admit(batch(100.1), 100.0, expected=0.0)) == [100.0, 100.1]


def test_the_rejection_says_where_the_batch_begins(sequence):
    assert is_rejected(sequence, batch(0.0)) == (
        "batch from 0 s: begins 10.0998 s before the end of the newest accepted, must continue it"
    )


@pytest.mark.parametrize(("begin", "is_another"), [(0.0, True), (50.0, False)])
def test_two_batches_that_continue_each_other_after_a_silence_are_both_admitted(
    sequence, begin, is_another
):
    is_rejected(sequence, batch(begin))
    admitted = sequence.admit(batch(begin + 0.1), 100.0)
    assert begins(admitted) == [begin, begin + 0.1]
    assert admitted.begins is is_another


def test_without_a_silence_nothing_takes_the_place_of_a_run(sequence):
    for number in range(10):
        is_rejected(sequence, batch(0.1 * number), now=0.9 * SILENCE)


@pytest.mark.parametrize("clock_first", [True, False])
def test_a_clock_that_went_back_speaks_for_the_first_batch_of_another_run(sequence, clock_first):
    if clock_first:
        assert not sequence.expect_restart().batches
        admitted = sequence.admit(batch(0.0), 0.0)
    else:
        is_rejected(sequence, batch(0.0))
        admitted = sequence.expect_restart()
    assert (begins(admitted), admitted.begins) == ([0.0], True)


@pytest.mark.parametrize("factor", [1e3, 1e-3])
def test_times_in_another_unit_are_rejected(sequence, factor):
    text = is_rejected(sequence, batch(10.1, step=STEP * factor), reason=Reason.SAMPLES)
    assert text == f"time step of {STEP * factor:g} s: must be about 0.0002 s"


def test_a_known_sample_time_holds_for_the_first_batch_too():
    is_rejected(TelemetrySequence(STEP), batch(0.0, step=0.2), reason=Reason.SAMPLES)


def test_a_single_row_is_a_batch():
    sequence = TelemetrySequence()
    assert begins(sequence.admit(batch(0.0, count=1), 0.0)) == [0.0]
    assert begins(sequence.admit(batch(0.1, count=1), 0.0)) == [0.1]


def test_what_is_of_no_use_leaves_a_hole_that_the_next_batch_tells_of(sequence):
    sequence.note_unusable(batch(10.1))
    admitted = sequence.admit(batch(10.2), 0.0)
    assert begins(admitted) == [10.2]
    assert admitted.hole[0, 0] == 10.1
    assert sequence.admit(batch(10.3), 0.0).hole is None


def test_what_is_of_no_use_may_be_a_stray_and_the_real_batch_come_after_it(sequence):
    sequence.note_unusable(batch(10.1))
    admitted = sequence.admit(batch(10.1), 0.0)
    assert (begins(admitted), admitted.hole) == ([10.1], None)


def test_what_is_of_no_use_and_stands_elsewhere_leaves_no_hole(sequence):
    sequence.note_unusable(batch(50.0))
    is_rejected(sequence, batch(50.1))
    assert sequence.admit(batch(10.1), 0.0).hole is None


@pytest.mark.parametrize("step", [STEP, None])
def test_batches_of_samples_that_come_in_bunches_continue_each_other(step):
    """Five samples each millisecond, stamped when they come, cut into batches anywhere."""
    numbers = np.arange(5000)
    rows = np.zeros((5000, 3))
    rows[:, 0] = numbers // 5 * 1e-3 + numbers % 5 * 1e-6
    sequence = TelemetrySequence(step)
    parts = np.split(rows, range(500, 5000, 500))
    admitted = [sequence.admit(part, 0.1 * number) for number, part in enumerate(parts)]
    assert [len(each.batches) for each in admitted] == [1] * 10
