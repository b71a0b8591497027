"""Callback groups: what may run at the same time."""

import threading
import time

import pytest
from rclpy.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import Float64
from std_srvs.srv import Trigger


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
    assert ros.processor_time(lambda: ros.spin_for(0.3)) < 0.15
    assert order == ["begins", "other group"]
    future.set_result(None)
    ros.spin_until(lambda: len(order) == 4)
    assert order[2:] == ["ends", "same group"]


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
    end = time.monotonic() + 20
    while len(done) < 6 and time.monotonic() < end:
        executor.spin_once(timeout_sec=0.05)
    assert len(done) == 6
    assert most["exclusive"] == 1
    assert most["reentrant"] > 1
    executor.shutdown()
    node.destroy_node()


@pytest.mark.parametrize("group_class", [MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup])
def test_entities_know_their_group(node, group_class):
    group = group_class()
    assert isinstance(group, CallbackGroup)
    entities = [
        node.create_subscription(Float64, "x", print, 1, callback_group=group),
        node.create_timer(1.0, print, callback_group=group),
        node.create_guard_condition(print, callback_group=group),
        node.create_client(Trigger, "s", callback_group=group),
        node.create_service(Trigger, "s", print, callback_group=group),
    ]
    assert all(entity.callback_group is group for entity in entities)
    assert all(group.has_entity(entity) for entity in entities)
    other = node.create_timer(1.0, print)
    assert not group.has_entity(other)
    assert other.callback_group is node.default_callback_group
    assert isinstance(node.default_callback_group, MutuallyExclusiveCallbackGroup)


def test_one_entity_at_a_time_enters_an_exclusive_group(node):
    group = MutuallyExclusiveCallbackGroup()
    first, second = (node.create_timer(1.0, print, callback_group=group) for _ in range(2))
    assert group.can_execute(first)
    assert group.beginning_execution(first)
    assert not group.can_execute(second)
    assert not group.beginning_execution(second)
    group.ending_execution(first)
    assert group.beginning_execution(second)


def test_a_reentrant_group_lets_all_in(node):
    group = ReentrantCallbackGroup()
    timer = node.create_timer(1.0, print, callback_group=group)
    assert group.beginning_execution(timer)
    assert group.can_execute(timer)
    assert group.beginning_execution(timer)
    group.ending_execution(timer)


def test_a_busy_group_does_not_hold_others_up(ros):
    node = Node("n", context=ros.context)
    executor = MultiThreadedExecutor(2, context=ros.context)
    executor.add_node(node)
    busy, free = threading.Event(), threading.Event()
    seen = []

    def block():
        busy.set()
        seen.append(free.wait(20))

    node.create_guard_condition(block).trigger()
    other = node.create_guard_condition(free.set, MutuallyExclusiveCallbackGroup())
    spinner = threading.Thread(target=executor.spin)
    spinner.start()
    assert busy.wait(20)
    other.trigger()
    ros.wait_until(lambda: seen)
    assert seen == [True]
    assert executor.shutdown(20)
    spinner.join(20)
    assert not spinner.is_alive()
    node.destroy_node()
