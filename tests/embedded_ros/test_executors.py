"""Executors of embedded_ros: what a pool of threads may do to whoever spins."""

import concurrent.futures
import threading
import time

import pytest
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


def test_a_thread_that_is_slow_to_end_with_an_exception_still_ends_spin(monkeypatch):
    """The future of the callback is done a while after the callback has raised."""
    set_exception = concurrent.futures.Future.set_exception

    def set_exception_late(future, error):
        time.sleep(0.2)
        set_exception(future, error)

    monkeypatch.setattr(concurrent.futures.Future, "set_exception", set_exception_late)

    def fail():
        raise ValueError("boom")

    context = Context()
    context.init()
    node = Node("n", context=context)
    executor = MultiThreadedExecutor(2, context=context)
    executor.add_node(node)
    node.create_guard_condition(fail).trigger()
    # Without the exception spin would return then.
    deadline = threading.Timer(10.0, context.try_shutdown)
    deadline.start()
    with pytest.raises(ValueError, match="boom"):
        executor.spin()
    deadline.cancel()
    executor.shutdown()
    node.destroy_node()
    context.try_shutdown()


def test_shutdown_does_not_wait_for_callbacks_that_have_not_begun():
    context = Context()
    context.init()
    node = Node("n", context=context)
    executor = MultiThreadedExecutor(2, context=context)
    executor.add_node(node)
    begun, may_end = threading.Semaphore(0), threading.Event()

    def block():
        begun.release()
        may_end.wait(60.0)

    group = ReentrantCallbackGroup()
    for _ in range(3):
        node.create_guard_condition(block, callback_group=group).trigger()
        executor.spin_once(20.0)
    for _ in range(2):
        assert begun.acquire(timeout=20.0)
    threading.Timer(0.1, may_end.set).start()
    assert executor.shutdown(20.0)
    assert not begun.acquire(blocking=False)
    node.destroy_node()
    context.try_shutdown()
