"""The loop below executors waits as often as there is something to wait for."""

import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node


@pytest.fixture
def executor():
    context = Context()
    rclpy.init(context=context, args=[])
    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(Node("n", context=context))
        yield executor
    context.shutdown()


@pytest.fixture
def waits(executor, monkeypatch):
    """Limits [ns] of the waits, as they begin."""
    begun, wait_set = [], executor._embedded._wait_set
    wait = wait_set.wait
    monkeypatch.setattr(wait_set, "wait", lambda limit: begun.append(limit) or wait(limit))
    return begun


def test_a_change_is_looked_at_before_the_wait_and_not_in_a_wait_of_its_own(executor, waits):
    (node,) = executor.get_nodes()
    executor.remove_node(node)
    executor.add_node(node)
    executor.spin_once(timeout_sec=0.01)
    # At the end of its time it looks once more without waiting.
    assert [limit > 0 for limit in waits] == [True, False]


def test_what_was_rung_for_before_the_look_is_not_forgotten(executor, waits):
    done = []
    executor.create_task(done.append, 1)
    executor.wake()
    executor.spin_once(timeout_sec=60)
    assert done == [1]
    assert waits == []
    executor.wake()
    executor.shutdown()
    executor.spin_once(timeout_sec=60)
    assert waits == []
