"""Executors, tasks, coroutines, callback groups."""

import threading
import time

import pytest
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import (
    ExternalShutdownException,
    MultiThreadedExecutor,
    SingleThreadedExecutor,
)
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Float64


@pytest.fixture
def node(ros):
    return ros.create(Node, "n")


def boom(*_):
    raise ValueError("boom")


def test_one_spin_runs_one_callback(ros, node):
    calls = []
    guards = [node.create_guard_condition(lambda: calls.append(1)) for _ in range(2)]
    for guard in guards:
        guard.trigger()
    ros.executor.spin_once(timeout_sec=1)
    assert len(calls) == 1
    ros.executor.spin_once(timeout_sec=1)
    assert len(calls) == 2


def test_a_timeout_ends_the_wait(ros, node):
    start = time.monotonic()
    ros.executor.spin_once(timeout_sec=0.05)
    ros.executor.spin_once(timeout_sec=0)
    assert 0.045 < time.monotonic() - start < 1


def test_a_node_is_added_once_and_removed(ros, node):
    assert not ros.executor.add_node(node)
    assert node.executor is ros.executor
    ros.executor.remove_node(node)
    node.create_guard_condition(boom).trigger()
    ros.executor.spin_once(timeout_sec=0.01)
    with SingleThreadedExecutor(context=ros.context) as other:
        assert other.add_node(node)
        assert other.get_nodes() == [node]
        assert node.executor is other


def test_what_a_callback_raises_comes_out_of_spin(ros, node):
    node.create_guard_condition(boom).trigger()
    with pytest.raises(ValueError, match="boom"):
        ros.executor.spin_once(timeout_sec=1)
    node.create_subscription(Float64, "x", boom, 1)
    node.create_publisher(Float64, "x", 1).publish(Float64())
    with pytest.raises(ValueError, match="boom"):
        ros.executor.spin_once(timeout_sec=1)
    # The group is free again: the next callback runs.
    calls = []
    node.create_guard_condition(lambda: calls.append(1)).trigger()
    ros.executor.spin_once(timeout_sec=1)
    assert calls


def test_tasks_give_results_and_exceptions(ros, node):
    task = ros.executor.create_task(lambda x, y: x + y, 1, y=2)
    assert ros.result(task) == 3
    failing = ros.executor.create_task(boom)
    with pytest.raises(ValueError, match="boom"):
        ros.executor.spin_until_future_complete(failing, 1)
    assert isinstance(failing.exception(), ValueError)


def test_coroutines_wait_for_futures_without_spinning_idly(ros, node):
    future = Future()
    steps = []

    async def wait():
        steps.append("waits")
        steps.append(await future)
        return "done"

    task = ros.executor.create_task(wait)
    ros.executor.spin_once(timeout_sec=1)
    cpu = time.process_time()
    ros.executor.spin_once(timeout_sec=0.2)
    assert time.process_time() - cpu < 0.05
    assert steps == ["waits"]
    threading.Timer(0.02, future.set_result, ["set"]).start()
    assert ros.result(task) == "done"
    assert steps == ["waits", "set"]


def test_a_suspended_callback_holds_its_group(ros, node):
    future = Future()
    order = []

    async def suspended():
        order.append("begins")
        await future
        order.append("ends")

    node.create_guard_condition(suspended).trigger()
    ros.executor.spin_once(timeout_sec=1)
    node.create_guard_condition(lambda: order.append("same group")).trigger()
    other_group = MutuallyExclusiveCallbackGroup()
    node.create_guard_condition(lambda: order.append("other group"), other_group).trigger()
    cpu = time.process_time()
    ros.spin_for(0.1)
    assert time.process_time() - cpu < 0.05
    assert order == ["begins", "other group"]
    future.set_result(None)
    ros.spin_until(lambda: len(order) == 4)
    assert order[2:] == ["ends", "same group"]


def test_a_coroutine_that_only_yields_lets_others_run(ros, node):
    calls = []

    class Pause:
        def __await__(self):
            yield

    async def forever():
        while len(calls) < 3:
            await Pause()

    task = ros.executor.create_task(forever)
    node.create_timer(0.005, lambda: calls.append(1))
    ros.spin_until(task.done)


def test_a_future_calls_back_when_it_is_done():
    future, seen = Future(), []
    future.add_done_callback(seen.append)
    assert not future.done()
    assert future.result() is None
    future.set_result(5)
    future.add_done_callback(seen.append)
    assert seen == [future, future]
    assert future.result() == 5
    cancelled = Future()
    cancelled.cancel()
    assert cancelled.cancelled()
    assert not cancelled.done()


def test_spin_until_a_future_is_done_in_another_thread(ros, node):
    future = Future()
    threading.Timer(0.05, future.set_result, [1]).start()
    start = time.monotonic()
    ros.executor.spin_until_future_complete(future, 10)
    assert future.done()
    assert time.monotonic() - start < 5
    never = Future()
    ros.executor.spin_until_future_complete(never, 0.01)
    assert not never.done()


def test_a_new_entity_wakes_an_executor_that_waits(ros, node):
    calls = []
    spinner = threading.Thread(target=lambda: ros.executor.spin_once(timeout_sec=10))
    spinner.start()
    node.create_timer(0.0, lambda: calls.append(1))
    spinner.join(5)
    assert calls == [1]


def test_entities_may_be_destroyed_while_they_are_ready(ros, node):
    calls = []
    guards = []

    def destroy_the_others():
        calls.append(1)
        for guard in guards:
            node.destroy_guard_condition(guard)

    guards += [node.create_guard_condition(destroy_the_others) for _ in range(5)]
    for guard in guards:
        guard.trigger()
    ros.spin_for(0.05)
    assert calls == [1]


@pytest.mark.parametrize("executor_class", [SingleThreadedExecutor, MultiThreadedExecutor])
def test_shutdown_from_another_thread_ends_spin(ros, executor_class):
    kwargs = {"num_threads": 2} if executor_class is MultiThreadedExecutor else {}
    executor = executor_class(context=ros.context, **kwargs)
    node = Node("other", context=ros.context)
    executor.add_node(node)
    spinner = threading.Thread(target=executor.spin)
    spinner.start()
    assert executor.shutdown(5)
    spinner.join(5)
    assert not spinner.is_alive()
    node.destroy_node()


def test_shutdown_of_the_context_ends_spin_with_an_exception(ros, node):
    threading.Timer(0.05, ros.context.shutdown).start()
    with pytest.raises(ExternalShutdownException):
        ros.executor.spin()
    ros.executor.spin()  # returns at once


def test_shutdown_in_a_callback_ends_spin_quietly(ros, node):
    node.create_guard_condition(ros.context.shutdown).trigger()
    ros.executor.spin()


def test_groups_decide_what_runs_at_the_same_time(ros):
    node = Node("n", context=ros.context)
    executor = MultiThreadedExecutor(4, context=ros.context)
    executor.add_node(node)
    running, most = [], {}

    def work(kind):
        running.append(kind)
        most[kind] = max(most.get(kind, 0), running.count(kind))
        time.sleep(0.02)  # that is the work
        running.remove(kind)

    done = []
    for kind, group in (
        ("reentrant", ReentrantCallbackGroup()),
        ("exclusive", MutuallyExclusiveCallbackGroup()),
    ):
        for _ in range(3):
            guard = node.create_guard_condition(lambda k=kind: (work(k), done.append(k)), group)
            guard.trigger()
    end = time.monotonic() + 10
    while len(done) < 6 and time.monotonic() < end:
        executor.spin_once(timeout_sec=0.05)
    assert len(done) == 6
    assert most["exclusive"] == 1
    assert most["reentrant"] > 1
    executor.shutdown()
    node.destroy_node()


def test_a_multi_threaded_executor_raises_what_a_callback_raised(ros):
    node = Node("n", context=ros.context)
    executor = MultiThreadedExecutor(2, context=ros.context)
    executor.add_node(node)
    node.create_guard_condition(boom).trigger()
    with pytest.raises(ValueError, match="boom"):
        executor.spin()
    executor.shutdown()
    node.destroy_node()


def test_an_idle_executor_uses_no_processor_time(ros, node):
    cpu = time.process_time()
    ros.executor.spin_once(timeout_sec=0.5)
    assert time.process_time() - cpu < 0.02


def test_a_future_cannot_be_subscripted_at_run_time_as_in_rclpy():
    with pytest.raises(TypeError, match="type 'Future' is not subscriptable"):
        Future[int]
