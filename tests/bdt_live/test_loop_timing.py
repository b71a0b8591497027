"""Rate and latency from when messages were sent."""

import pytest

from bdt_live.loop_timing import SECOND, LoopTiming


def test_latency_is_the_median_from_a_measurement_to_its_answer():
    timing = LoopTiming()
    for stamp, latency in ((0, 100), (2, 900), (4, 300)):
        timing.measured(stamp, 1_000_000)
        timing.commanded(stamp, 1_000_000 + latency)
    assert timing.latency == pytest.approx(300e-9)


def test_commands_that_answer_nothing_that_was_noted_do_not_count():
    timing = LoopTiming()
    timing.commanded(7, 5)
    assert timing.latency is None


def test_the_rate_is_that_of_the_last_second():
    timing = LoopTiming()
    for tenth in range(21):
        now = (1000 + tenth) * 100_000_000
        timing.count(50, now, now)
    assert timing.rate == pytest.approx(500.0)


def test_however_late_somebody_looks_the_rate_is_that_of_sending():
    timing = LoopTiming()
    timing.count(1, 100 * SECOND, 101 * SECOND)
    timing.count(1500, 103 * SECOND, 107 * SECOND)
    assert timing.rate == pytest.approx(500.0)


def test_a_loop_that_says_nothing_any_more_has_no_rate():
    timing = LoopTiming()
    timing.count(1, 100 * SECOND, 100 * SECOND)
    timing.count(500, 101 * SECOND, 101 * SECOND)
    timing.count(0, 0, 104 * SECOND)
    assert timing.rate == 0.0
