"""Spinning at intervals: nothing that was sent before a signal is left behind."""

import os
import signal
from itertools import pairwise

import pytest

from bdt_msgs_py import spinning
from bdt_msgs_py.spinning import (
    DRAIN_TIMEOUT,
    IDLE_TIME,
    SPIN_PERIOD,
    drain_messages,
    spin_at_intervals,
    spin_at_intervals_until,
)

LOOK = 1e-5
"""Time that a look takes [s]."""


class WallClock:
    """A wall clock on which nothing takes time but looks and sleep."""

    def __init__(self):
        self.now = 1000.0

    def monotonic(self):
        return self.now

    def sleep(self, duration):
        self.now += duration


class Node:
    """A node that has taken nothing yet."""

    messages = 0


class Executor:
    """Takes what is in its queue, a message or something else at a time."""

    def __init__(self, node, queue, clock):
        self.node, self.queue, self.clock = node, list(queue), clock
        self.looks = []

    def spin_once(self, timeout_sec):
        assert timeout_sec == 0.0
        self.looks.append(self.clock.now)
        self.clock.now += LOOK
        taken = self.queue.pop(0) if self.queue else None
        if taken == "message":
            self.node.messages += 1
        elif taken == "signal":
            os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture(autouse=True)
def clock(monkeypatch):
    """Return the clock: how busy the machine is does not matter."""
    own = WallClock()
    monkeypatch.setattr(spinning, "time", own)
    return own


@pytest.fixture(autouse=True)
def handler():
    before = signal.getsignal(signal.SIGINT)
    yield
    assert signal.getsignal(signal.SIGINT) is before


def test_what_waits_at_a_signal_is_taken_though_other_work_comes_between(clock):
    node = Node()
    queue = ["message", "signal", "message", "timer", "message", "timer", "timer", "message"]
    spin_at_intervals(Executor(node, queue, clock), node)
    assert node.messages == 4


def test_it_ends_soon_after_the_last_message(clock):
    node, begin = Node(), clock.now
    spin_at_intervals(Executor(node, ["signal", "message"], clock), node)
    assert IDLE_TIME <= clock.now - begin < IDLE_TIME + 2 * SPIN_PERIOD


def test_what_waits_is_taken_without_a_signal_though_other_work_comes_between(clock):
    node, begin = Node(), clock.now
    drain_messages(Executor(node, ["timer", "timer", "timer", "message"] * 3, clock), node)
    assert node.messages == 3
    assert IDLE_TIME <= clock.now - begin < IDLE_TIME + 8 * SPIN_PERIOD


def test_a_stream_that_goes_on_is_left(clock):
    """The loop that is recorded may well go on when the recorder is stopped."""
    node, begin = Node(), clock.now
    stream = ["nothing", "nothing", "message"] * round(2 * DRAIN_TIMEOUT / SPIN_PERIOD)
    spin_at_intervals(Executor(node, ["signal", *stream], clock), node)
    assert DRAIN_TIMEOUT <= clock.now - begin < DRAIN_TIMEOUT + 2 * SPIN_PERIOD


def test_messages_are_taken_at_once_and_silence_is_waited_out(clock):
    node = Node()
    executor = Executor(node, ["message"] * 50 + ["timer"] * 6 + ["signal"], clock)
    spin_at_intervals(executor, node)
    steps = [after - before for before, after in pairwise(executor.looks)]
    assert steps[:50] == pytest.approx([LOOK] * 50)
    silent = steps[50:56]
    assert [step >= SPIN_PERIOD for step in silent] == [False, True] * 3


def test_a_look_without_a_message_between_two_messages_costs_no_time(clock):
    """So rclpy does it: the look that ends a wait set finds nothing."""
    node = Node()
    executor = Executor(node, ["message", "nothing"] * 50 + ["signal"], clock)
    spin_at_intervals(executor, node)
    assert executor.looks[99] - executor.looks[0] == pytest.approx(99 * LOOK)
    assert node.messages == 50


def test_who_needs_no_rest_ends_at_once_by_a_word_or_a_signal(clock):
    """Where a loop goes on, messages would be waited out for seconds."""
    node = Node()
    spin_at_intervals_until(
        Executor(node, ["message"] * 5, clock), node, lambda: node.messages == 3
    )
    assert node.messages == 3
    queue = ["message", "signal", *["message"] * 5]
    spin_at_intervals_until(Executor(node, queue, clock), node, lambda: False)
    assert node.messages == 4
