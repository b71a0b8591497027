"""Runs and strays of a topic, by the times that its messages tell."""

import numpy as np
import pytest

from bdt_bags.reading.message_runs import STRAY, MessageSpans, runs_of_messages

GRID = np.arange(400) * 0.002


def runs(times, received=None, lengths=0.0, data=None):
    """Return the runs of messages that tell these times, received in this order by default."""
    times = np.array(times, float)
    received = range(0, 10**7 * times.size, 10**7) if received is None else received
    data = [b"%r" % time for time in times.tolist()] if data is None else data
    return runs_of_messages(MessageSpans(times, times + lengths, list(received), data)).tolist()


def with_strays(times, *strays):
    """Return times with strays, each given as (place, time), and which numbers are expected."""
    times, expected = list(times), [0] * len(times)
    for place, time in sorted(strays, reverse=True):
        times.insert(place, time)
        expected.insert(place, STRAY)
    return times, expected


@pytest.mark.parametrize(
    ("times", "expected"),
    [
        ([], []),
        ([np.nan], [STRAY]),
        ([5.0], [0]),
        ([0, 1, 2, 3], [0, 0, 0, 0]),
        ([0, 0, 0, 1, 1, 2], [0] * 6),  # repeated
        ([0, 1, 3, 2, 4, 5], [0] * 6),  # late
        ([1, 0, 3, 2, 5, 4], [0] * 6),  # each two exchanged
        ([0, 1, 2, 0, 1, 2, 3], [0, 0, 0, 1, 1, 1, 1]),
        ([0, 1, 2, 0, 1, 2, 0, 1], [0, 0, 0, 1, 1, 1, 2, 2]),
        ([3, 4, 5, 0, 1, 2, 3, 4, 5, 6], [0] * 3 + [1] * 7),  # both beginnings missed
        ([0, 1, np.nan, 0, np.nan, 0.5], [0, 0, STRAY, 1, STRAY, 1]),
        ([0, 1, 2, 50, 51, 52], [0] * 6),  # a gap
        ([0, 1, 2, 3, 2.5, 2.5], [0, 0, 0, 0, STRAY, STRAY]),
    ],
)
def test_a_run_begins_where_time_goes_back_and_goes_on(times, expected):
    assert runs(times, received=[10**9 * k for k in range(len(times))]) == expected


def test_the_order_of_reception_counts_and_not_that_of_the_bag():
    assert runs([2.0, 3.0, 0.0, 1.0], [20, 30, 0, 10]) == [0, 0, 0, 0]


@pytest.mark.parametrize("place", [0, 1, 200, 399, 400])
@pytest.mark.parametrize("time", [-1e6, -1.0, 0.1, 0.1007, 0.79, 1.0, 800.0, 3e9])
def test_one_stray_of_any_time_is_the_only_one_left_out(place, time):
    """Unless it stands for the time that follows, or repeats one that is there."""
    times, expected = with_strays(GRID, (place, time))
    found = runs(times, data=[b"%d" % k for k in range(len(times))])
    assert len(expected) - 1 <= found.count(0)
    assert found.count(STRAY) == 1
    if time in (-1e6, 3e9, 800.0):
        assert found == expected


def test_strays_that_go_on_from_each_other_among_those_of_a_run():
    """Another plant, a while behind or ahead, for a shorter time."""
    for offset in (-0.3017, -0.3, 0.05, 0.3, 100.0):
        pairs = [(2 * k + 100, GRID[100 + k] + offset) for k in range(60)]
        strays = [(place - k, time) for k, (place, time) in enumerate(pairs)]
        times, expected = with_strays(GRID, *strays)
        found = np.array(runs(times, data=[b"%d" % k for k in range(len(times))]))
        assert (found == np.array(expected)).mean() > 0.98, offset


def test_more_strays_in_a_row_than_patience():
    times, expected = with_strays(GRID, *((200, 3e9 + k) for k in range(50, 0, -1)))
    assert runs(times) == expected


@pytest.mark.parametrize("count", [1, 2, 10])
def test_strays_just_ahead_of_a_run_do_not_part_it(count):
    strays = [(200, GRID[200] + 0.0303 + 0.002 * k) for k in range(count, 0, -1)]
    times, expected = with_strays(GRID, *strays)
    assert runs(times) == expected


def test_a_stray_between_two_messages_of_a_regular_grid():
    times, expected = with_strays(GRID, (200, GRID[199] + 0.0007))
    assert runs(times) == expected


def test_stamps_that_jitter_are_no_strays():
    jitter = np.random.default_rng(1).uniform(-0.45, 0.45, GRID.size) * 0.002
    assert set(runs(GRID + jitter)) == {0}


def test_the_first_of_two_for_the_same_time_counts():
    times = [0.0, 0.002, 0.004, 0.004, 0.004, 0.006]
    assert runs(times, data=[b"a", b"b", b"c", b"c", b"x", b"d"]) == [0, 0, 0, 0, STRAY, 0]


def test_late_and_repeated_ones_have_their_place_among_messages_of_many_rows():
    begins = np.arange(20) * 0.1
    order = [*range(10), 12, 13, 10, 11, *range(14, 20), 3]
    assert set(runs(begins[order], lengths=0.0998)) == {0}


@pytest.mark.parametrize(
    ("begin", "length"), [(0.95, 0.0998), (0.95, 0.0), (0.9999, 0.0), (0.5, 1.0), (1.0, 3e9)]
)
def test_a_stray_of_other_rows_does_not_part_a_run(begin, length):
    begins, lengths = np.arange(20) * 0.1, np.full(20, 0.0998)
    times, expected = with_strays(begins, (10, begin))
    assert runs(times, lengths=np.insert(lengths, 10, length)).count(STRAY) == 1
    # The one that comes first keeps its place where both tell of the same time.
    if begin != 1.0:
        assert runs(times, lengths=np.insert(lengths, 10, length)) == expected


def test_a_run_is_not_gone_through_for_each_message(count_calls):
    calls = [
        count_calls(lambda n=n: runs(np.arange(n) * 0.002, data=[b""] * n)) for n in (50, 50, 5000)
    ]
    assert calls[2] < 1.5 * calls[1]
