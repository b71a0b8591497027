"""What a recording lacks: counted where something was lost, told where nothing could be there."""

import numpy as np
import pytest

from bdt_bags.reading.completeness import (
    late_beginnings,
    lost_in_queue,
    lost_messages,
    missing_batches,
    missing_in_loop,
    missing_stamps,
)
from bdt_bags.reading.recording import load_recording
from bdt_bags.reading.recording_clock import MessageTimes
from bdt_msgs_py.topics import COMMAND, MEASUREMENT, TELEMETRY

PERIOD = 0.002


def stamp_of(item):
    stamp = item[3].header.stamp
    return stamp.sec + stamp.nanosec * 1e-9


@pytest.mark.parametrize(("topic", "every"), [(MEASUREMENT, 700), (COMMAND, 700), (TELEMETRY, 7)])
def test_lost_messages(following_loop, tmp_path, topic, every):
    name = f"/{topic.name}"
    numbers = [k for k, item in enumerate(following_loop.items) if item[0] == name]
    dropped = set(numbers[1::every])
    messages = following_loop.without()
    messages.items = [x for k, x in enumerate(messages.items) if k not in dropped]
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert lost_messages(recording) == (len(dropped), 0)
    assert late_beginnings(recording) == ()


def test_a_measurement_that_was_never_sent_is_one_message_and_has_no_command(
    following_loop, tmp_path
):
    """A plant that gets no processor leaves steps out; nobody answers what was not asked."""
    messages = following_loop.without()
    for topic in (MEASUREMENT, COMMAND):
        sent = [x for x in messages.items if x[0] == f"/{topic.name}"]
        unsent = {id(x) for x in sent if 3.0 <= stamp_of(x) < 3.08}
        messages.items = [x for x in messages.items if id(x) not in unsent]
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert lost_messages(recording) == (40, 0)


def test_commands_without_measurements_are_counted_by_their_period(following_loop, tmp_path):
    numbers = [k for k, x in enumerate(following_loop.items) if x[0] == f"/{COMMAND.name}"]
    dropped = set(numbers[1::700])
    messages = following_loop.without()
    messages.items = [
        x
        for k, x in enumerate(messages.items)
        if k not in dropped and x[0] != f"/{MEASUREMENT.name}"
    ]
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert lost_messages(recording).total == len(dropped)


def test_what_a_queue_has_lost_of_both_topics_are_two_messages_each():
    stamps = np.arange(500) * PERIOD
    delayed = stamps.copy()
    delayed[140:150] = stamps[150] - 1e-5 * (150 - np.arange(140, 150))
    kept = np.delete(np.arange(500), np.arange(100, 140))
    times = MessageTimes(stamps[kept], delayed[kept])
    assert missing_in_loop(times, times, stamps[-1]) == (80, 80)
    on_time = MessageTimes(stamps[kept], stamps[kept])
    assert missing_in_loop(on_time, on_time, stamps[-1]) == (40, 0)


def test_recording_that_began_late_has_lost_nothing(following_loop, tmp_path):
    messages = following_loop.without()
    messages.items = [item for item in messages.items if item[2] > 7.0]
    messages.reference(5.0, 0.0)
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert lost_messages(recording).total == 0
    assert late_beginnings(recording) == ()


@pytest.mark.parametrize("late", [(MEASUREMENT,), (MEASUREMENT, COMMAND), (TELEMETRY,)])
def test_a_topic_that_is_found_later_than_the_others_has_lost_nothing(small_loop, tmp_path, late):
    """A recorder that looks for topics finds one after the other while the loop runs."""
    names = {f"/{topic.name}" for topic in late}
    messages = small_loop.without()
    messages.items = [x for x in messages.items if x[0] not in names or x[2] > 0.55]
    recording = load_recording(messages.write(tmp_path / "bag"))
    assert lost_messages(recording).total == 0
    first = 0.5 if late == (TELEMETRY,) else 0.56
    assert late_beginnings(recording) == tuple(
        f"no {topic.name} before t = {first:g} s: the recorder came later" for topic in late
    )


def test_missing_stamps():
    grid = np.arange(100) * PERIOD
    assert missing_stamps(grid, grid[-1]) == 0
    assert missing_stamps(np.append(grid, grid), grid[-1] + 0.0018) == 0
    assert missing_stamps(np.delete(grid, [0, 50, 51, 99]), grid[-1]) == 3
    assert missing_stamps(grid[:1], 1.0) == 0


def test_missing_batches():
    times = np.arange(1000) * 0.01
    assert missing_batches(times, 100, 10.5) == 0
    assert missing_batches(times, 100, 11.0) == 1
    assert missing_batches(np.delete(times, slice(200, 400)), 100, 10.0) == 2
    assert missing_batches(times[100:], 100, np.nan) == 0


@pytest.mark.parametrize("pace", [1.0, 8.0])
def test_what_a_queue_has_lost_is_told_from_what_a_network_has(pace):
    """A recorder that stands still finds the last ten messages, and takes them at once."""
    stamps = np.arange(500) * PERIOD
    received = stamps / pace + np.random.default_rng(1).uniform(0, 0.2 * PERIOD / pace, 500)
    lost = np.arange(100, 140)
    waiting = np.arange(140, 150)
    delayed = received.copy()
    delayed[waiting] = received[150] - 1e-5 * (150 - waiting) / pace
    kept = np.delete(np.arange(500), lost)
    assert lost_in_queue(MessageTimes(stamps[kept], delayed[kept])) == 40
    assert lost_in_queue(MessageTimes(stamps[kept], received[kept])) == 0
    assert lost_in_queue(MessageTimes(stamps, delayed)) == 0
    assert lost_in_queue(MessageTimes(stamps[:2], received[:2])) == 0
