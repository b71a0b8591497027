"""Spinning in strokes: nothing that was sent before a signal is left behind."""

import os
import signal
import time
from itertools import pairwise

import pytest

from bdt_bringup.running.strokes import QUIET, STROKE, spin_in_strokes


class Node:
    """A node that has taken nothing yet."""

    messages = 0


class Executor:
    """Takes what is in its queue, a message or something else at a time."""

    def __init__(self, node, queue):
        self.node, self.queue = node, list(queue)
        self.looks = []

    def spin_once(self, timeout_sec):
        assert timeout_sec == 0.0
        self.looks.append(time.monotonic())
        taken = self.queue.pop(0) if self.queue else None
        if taken == "message":
            self.node.messages += 1
        elif taken == "signal":
            os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture(autouse=True)
def handler():
    before = signal.getsignal(signal.SIGINT)
    yield
    assert signal.getsignal(signal.SIGINT) is before


def test_what_waits_at_a_signal_is_taken_though_other_work_comes_between():
    node = Node()
    queue = ["message", "signal", "message", "timer", "message", "timer", "timer", "message"]
    spin_in_strokes(Executor(node, queue), node)
    assert node.messages == 4


def test_it_ends_soon_after_the_last_message():
    node = Node()
    executor = Executor(node, ["signal", "message"])
    begin = time.monotonic()
    spin_in_strokes(executor, node)
    assert QUIET <= time.monotonic() - begin < QUIET + 1.0


def test_messages_are_taken_at_once_and_silence_is_waited_out():
    node = Node()
    executor = Executor(node, ["message"] * 50 + ["timer"] * 6 + ["signal"])
    spin_in_strokes(executor, node)
    steps = [after - before for before, after in pairwise(executor.looks)]
    assert sum(steps[:50]) < 50 * STROKE
    silent = steps[50:56]
    assert [step >= STROKE for step in silent] == [False, True] * 3


def test_a_look_without_a_message_between_two_messages_costs_no_time():
    """So rclpy does it: the look that ends a wait set finds nothing."""
    node = Node()
    executor = Executor(node, ["message", "nothing"] * 50 + ["signal"])
    spin_in_strokes(executor, node)
    assert executor.looks[99] - executor.looks[0] < 50 * STROKE
    assert node.messages == 50
