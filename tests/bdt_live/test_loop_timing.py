"""Rate and latency from when messages were sent."""

import pytest

from bdt_live.loop_timing import LoopTiming


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
        timing.count(50, 100.0 + tenth / 10)
    assert timing.rate == pytest.approx(500.0)
