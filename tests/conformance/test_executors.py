"""Executors: what they run, in which order, and how they end."""

import threading
import time

import pytest
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.executors import (
    ConditionReachedException,
    Executor,
    ExternalShutdownException,
    MultiThreadedExecutor,
    ShutdownException,
    SingleThreadedExecutor,
    TimeoutException,
)
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Float64


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
    assert 0.045 < time.monotonic() - start < 10


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


@pytest.mark.parametrize("executor_class", [SingleThreadedExecutor, MultiThreadedExecutor])
def test_one_spin_ends_when_another_thread_completes_the_future(ros, executor_class):
    kwargs = {"num_threads": 2} if executor_class is MultiThreadedExecutor else {}
    executor = executor_class(context=ros.context, **kwargs)
    node = Node("n", context=ros.context)
    executor.add_node(node)
    done, failed = Future(), Future()
    timers = [
        threading.Timer(0.05, done.set_result, [1]),
        threading.Timer(0.05, failed.set_exception, [ValueError("boom")]),
    ]
    for timer, future in zip(timers, (done, failed), strict=True):
        timer.start()
        start = time.monotonic()
        executor.spin_once_until_future_complete(future, 60)
        assert future.done()
        assert time.monotonic() - start < 30
        timer.join()
    assert isinstance(failed.exception(), ValueError)
    executor.shutdown()
    node.destroy_node()


def test_a_cancelled_future_is_waited_for_until_the_time_is_over(ros, node):
    future = Future()
    threading.Timer(0.01, future.cancel).start()
    start = time.monotonic()
    ros.executor.spin_until_future_complete(future, 0.2)
    assert time.monotonic() - start > 0.19
    assert future.cancelled()


def test_a_new_entity_wakes_an_executor_that_waits(ros, node):
    calls = []
    spinner = threading.Thread(target=lambda: ros.executor.spin_once(timeout_sec=10))
    spinner.start()
    node.create_timer(0.0, lambda: calls.append(1))
    spinner.join(20)
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
    assert executor.shutdown(20)
    spinner.join(20)
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
    assert ros.processor_time(lambda: ros.executor.spin_once(timeout_sec=0.5)) < 0.1


@pytest.mark.parametrize("executor_class", [SingleThreadedExecutor, MultiThreadedExecutor])
def test_a_node_belongs_to_one_executor(ros, executor_class):
    node = Node("other", context=ros.context)
    first = SingleThreadedExecutor(context=ros.context)
    second = executor_class(context=ros.context)
    assert node.executor is None
    assert first.add_node(node)
    node.executor = second
    assert first.get_nodes() == []
    assert second.get_nodes() == [node]
    node.executor = None
    assert second.get_nodes() == []
    assert second.context is ros.context
    first.shutdown()
    second.shutdown()
    node.destroy_node()


def test_entities_are_served_by_kind(ros, node):
    order = []
    publisher = node.create_publisher(Float64, "x", 1)
    node.create_guard_condition(lambda: order.append("guard condition")).trigger()
    node.create_subscription(Float64, "x", lambda _: order.append("subscription"), 1)
    publisher.publish(Float64())
    timer = node.create_timer(0.0, lambda: (order.append("timer"), timer.cancel()))
    ros.spin_until(lambda: len(order) == 3)
    assert order == ["timer", "subscription", "guard condition"]


def test_entities_of_a_kind_are_served_in_the_order_of_their_creation(ros, node):
    count, order = 20, []
    publishers = [node.create_publisher(Float64, f"x{i}", 1) for i in range(count)]
    guards = []
    for i in range(count):
        node.create_subscription(Float64, f"x{i}", lambda _, i=i: order.append(("message", i)), 1)
        guards.append(node.create_guard_condition(lambda i=i: order.append(("trigger", i))))
    ros.spin_for(0.02)
    for _ in range(3):
        order.clear()
        for i in reversed(range(count)):
            publishers[i].publish(Float64())
            guards[i].trigger()
        ros.spin_until(lambda: len(order) == 2 * count)
        assert [i for kind, i in order if kind == "message"] == list(range(count))
        assert [i for kind, i in order if kind == "trigger"] == list(range(count))


def test_who_is_always_ready_lets_the_others_have_their_turn(ros, node):
    # Each serves itself again. With a depth of one there is always just one message.
    counts = [0] * 4
    publishers = [node.create_publisher(Float64, f"x{i}", 1) for i in range(len(counts))]

    def again(i):
        counts[i] += 1
        publishers[i].publish(Float64())

    for i, publisher in enumerate(publishers):
        node.create_subscription(Float64, f"x{i}", lambda _, i=i: again(i), 1)
        publisher.publish(Float64())
    ros.spin_until(lambda: sum(counts) >= 200)
    assert max(counts) - min(counts) <= 2


def test_events_come_before_messages(ros, node):
    order = []
    callbacks = SubscriptionEventCallbacks(matched=lambda _: order.append("event"))
    publisher = node.create_publisher(Float64, "x", 1)
    node.create_subscription(
        Float64, "x", lambda _: order.append("message"), 1, event_callbacks=callbacks
    )
    publisher.publish(Float64())
    ros.spin_until(lambda: len(order) == 2)
    assert order == ["event", "message"]


def test_an_executor_of_ones_own_decides_where_callbacks_run(ros):
    class Sorting(Executor):
        def __init__(self):
            super().__init__(context=ros.context)
            self.served = []

        def spin_once(self, timeout_sec=None):
            try:
                handler, entity, node = self.wait_for_ready_callbacks(timeout_sec=timeout_sec)
            except TimeoutException:
                return
            handler()
            self.served.append((entity, node))
            if handler.exception() is not None:
                raise handler.exception()

    executor, node, calls = Sorting(), Node("n", context=ros.context), []
    executor.add_node(node)
    guard = node.create_guard_condition(lambda: calls.append(1))
    guard.trigger()
    executor.spin_once(timeout_sec=20)
    assert calls == [1]
    assert executor.served == [(guard, node)]
    executor.spin_once(timeout_sec=0.01)
    assert calls == [1]
    assert executor.can_execute(guard)
    node.create_guard_condition(boom).trigger()
    with pytest.raises(ValueError, match="boom"):
        executor.spin_once(timeout_sec=20)
    executor.shutdown()
    with pytest.raises(ShutdownException):
        executor.wait_for_ready_callbacks(timeout_sec=1)
    node.destroy_node()


def test_a_wait_ends_when_its_condition_holds(ros, node):
    with pytest.raises(ConditionReachedException):
        ros.executor.wait_for_ready_callbacks(timeout_sec=20, condition=lambda: True)


def test_a_guard_condition_triggered_twice_calls_once(ros, node):
    calls = []
    guard = node.create_guard_condition(lambda: calls.append(1))
    guard.trigger()
    guard.trigger()
    ros.spin_for(0.02)
    assert calls == [1]
    assert list(node.guards) == [guard]
    assert node.destroy_guard_condition(guard)
    assert not node.destroy_guard_condition(guard)


def test_a_callback_may_create_what_runs_next(ros, node):
    calls = []

    def create():
        node.create_guard_condition(lambda: calls.append(1)).trigger()

    node.create_guard_condition(create).trigger()
    ros.spin_until(lambda: calls)


def test_a_callback_may_add_and_remove_nodes(ros, node):
    other = Node("other", context=ros.context)
    calls = []
    other.create_guard_condition(lambda: (calls.append(1), swap(node, other))).trigger()

    def swap(come, go):
        ros.executor.remove_node(go)
        ros.executor.add_node(come)

    node.create_guard_condition(lambda: swap(other, node)).trigger()
    ros.spin_until(lambda: calls)
    assert ros.executor.get_nodes() == [node]
    other.destroy_node()


def test_a_multi_threaded_executor_runs_many_callbacks(ros):
    node = Node("n", context=ros.context)
    executor = MultiThreadedExecutor(3, context=ros.context)
    executor.add_node(node)
    threads = set()
    received = []

    def receive(message):
        threads.add(threading.current_thread())
        received.append(message.data)

    node.create_subscription(Float64, "x", receive, 100)
    publisher = node.create_publisher(Float64, "x", 100)
    for value in range(50):
        publisher.publish(Float64(data=float(value)))
    end = time.monotonic() + 20
    while len(received) < 50 and time.monotonic() < end:
        executor.spin_once(timeout_sec=0.1)
    assert received == list(range(50))
    assert threading.main_thread() not in threads
    executor.shutdown()
    node.destroy_node()


def test_one_thread_is_too_few_for_a_multi_threaded_executor(ros):
    with pytest.warns(UserWarning, match="single thread"):
        MultiThreadedExecutor(1, context=ros.context).shutdown()


def test_a_context_manager_shuts_the_executor_down(ros):
    with SingleThreadedExecutor(context=ros.context) as executor:
        executor.spin_once(timeout_sec=0)
    executor.spin()  # returns at once
