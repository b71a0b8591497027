"""Timing of streams and commands with known answers."""

import numpy as np
import pytest

from bdt_analysis.metrics.loop_timing import command_latencies, stream_timing, summarize_timing
from bdt_bags.reading.recording import load_recording
from bdt_bags.reading.recording_clock import NO_MESSAGES, MessageTimes
from bdt_msgs_py.topics import COMMAND, TELEMETRY

STAMPS = np.arange(1000) * 0.002


def test_regular_stream():
    timing = stream_timing(MessageTimes(STAMPS, 5.0 + 0.5 * STAMPS))
    assert timing.messages == 1000
    assert timing.period_s == pytest.approx(0.002)
    assert timing.arrival_period_s == pytest.approx(0.001)
    assert timing.stamp_jitter_max_s < 1e-12
    assert timing.arrival_jitter_max_s < 1e-12
    assert (timing.gaps, timing.longest_gap_s, timing.repeated) == (0, None, 0)


def test_jitter_of_the_arrival_only():
    """Every other message is late by 0.4 ms: times between two of them are off by as much."""
    late = 0.0004 * (np.arange(1000) % 2)
    timing = stream_timing(MessageTimes(STAMPS, STAMPS + late))
    assert timing.stamp_jitter_max_s < 1e-12
    assert timing.arrival_jitter_rms_s > 0.0004
    assert timing.arrival_jitter_max_s == pytest.approx(0.0008, rel=1e-3)


def test_jitter_of_the_stamps():
    random = np.random.default_rng(5)
    noise = 1e-5 * random.standard_normal(1000)
    timing = stream_timing(MessageTimes(STAMPS + noise, STAMPS))
    assert timing.stamp_jitter_rms_s == pytest.approx(np.sqrt(2) * 1e-5, rel=0.1)
    assert timing.gaps == 0


def test_gaps():
    lost = np.delete(STAMPS, [100, 500, 501, 502])
    timing = stream_timing(MessageTimes(lost, lost))
    assert timing.gaps == 2
    assert timing.longest_gap_s == pytest.approx(0.008)
    assert timing.longest_gap_begins_s == pytest.approx(0.998)
    assert timing.stamp_jitter_max_s < 1e-12, "a gap is not jitter"


def test_repeated_and_disordered_messages_are_no_gaps():
    order = np.random.default_rng(1).permutation(np.append(np.arange(1000), [7, 7, 8]))
    timing = stream_timing(MessageTimes(STAMPS[order], np.arange(1003) * 1.0))
    assert (timing.messages, timing.repeated, timing.gaps) == (1003, 3, 0)


def test_nothing_and_one_message():
    nothing = stream_timing(NO_MESSAGES)
    assert nothing.messages == nothing.gaps == 0
    assert nothing.period_s is nothing.arrival_period_s is None
    assert stream_timing(MessageTimes(np.ones(1), np.ones(1))).period_s is None


def test_latency():
    measurements = MessageTimes(STAMPS, STAMPS)
    commands = MessageTimes(STAMPS[::2], STAMPS[::2] + 0.0003)
    rows = command_latencies(measurements, commands)
    assert rows[:, 0].tolist() == STAMPS[::2].tolist()
    assert rows[:, 1] == pytest.approx(np.full(500, 0.0003))


def test_latency_counts_from_the_last_measurement_before_the_command():
    measurements = MessageTimes(np.array([0.0, 0.0, 0.0, 1.0]), np.array([1.0, 2.0, 5.0, 6.0]))
    commands = MessageTimes(np.array([0.0, 0.0, 1.0, 9.0]), np.array([2.5, 4.0, 5.9, 9.0]))
    assert command_latencies(measurements, commands).tolist() == [
        [0.0, pytest.approx(0.5)],
        [1.0, pytest.approx(-0.1)],
    ]


def test_recording(following_loop, tmp_path):
    """In the built bag, what belongs to one time comes at once, at four times the pace."""
    numbers = [k for k, item in enumerate(following_loop.items) if item[0] == "/command"]
    dropped = set(numbers[10::1000])
    messages = following_loop.without(TELEMETRY)
    messages.items = [x for k, x in enumerate(following_loop.items) if k not in dropped]
    timing = summarize_timing(load_recording(messages.write(tmp_path / "bag")))
    assert timing.measurement.period_s == pytest.approx(0.002)
    assert timing.measurement.arrival_period_s == pytest.approx(0.0005)
    assert timing.telemetry.period_s == pytest.approx(0.1)
    assert timing.command.gaps == timing.latency.unanswered == len(dropped) == 10
    assert timing.latency.answered == 9990
    assert timing.latency.max_s == 0.0


def test_recording_without_commands(small_loop, tmp_path):
    timing = summarize_timing(load_recording(small_loop.without(COMMAND).write(tmp_path / "bag")))
    assert (timing.latency.answered, timing.latency.unanswered) == (0, 100)
    assert timing.latency.median_s is timing.command.period_s is None
