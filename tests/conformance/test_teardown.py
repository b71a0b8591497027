"""The end of things: in any order, while they are used, and many times."""

import itertools
import os
import subprocess
import sys
import threading

import pytest
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import (
    ExternalShutdownException,
    MultiThreadedExecutor,
    SingleThreadedExecutor,
)
from rclpy.node import Node
from std_msgs.msg import Float64
from std_srvs.srv import Trigger


@pytest.mark.parametrize("order", list(itertools.permutations(["context", "node", "executor"])))
def test_teardown_in_any_order(order):
    context = Context()
    context.init(args=[])
    node = Node("n", context=context)
    publisher = node.create_publisher(Float64, "x", 10)
    node.create_subscription(Float64, "x", print, 10)
    node.create_timer(0.001, lambda: None)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    publisher.publish(Float64())
    steps = {
        "context": context.try_shutdown,
        "node": node.destroy_node,
        "executor": executor.shutdown,
    }
    for step in order:
        steps[step]()
    for step in order:
        steps[step]()


LEAVING = """
import sys
import rclpy
from rclpy.node import Node
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import Float64
rclpy.init(args=[])
node = Node("n")
publisher = node.create_publisher(Float64, "x", 10)
node.create_subscription(Float64, "x", lambda msg: None, 10)
how = sys.argv[1]
executor = SingleThreadedExecutor()
executor.add_node(node)
if how == "exception":
    raise SystemExit(5)
elif how == "cycle":
    node.me = node
    del node, executor, publisher
print("leaves")
"""


# Not with a daemon thread that spins: it makes rclpy 7.1 abort.
@pytest.mark.parametrize(
    ("how", "code"),
    [("plain", 0), ("exception", 5), ("cycle", 0)],
)
def test_a_program_may_end_without_cleaning_up(how, code):
    done = subprocess.run(
        [sys.executable, "-c", LEAVING, how],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == code
    assert done.stderr == ""


def test_many_nodes_come_and_go(ros):
    for index in range(200):
        node = Node(f"n{index}", context=ros.context, start_parameter_services=False)
        node.create_timer(1.0, lambda: None)
        ros.executor.add_node(node)
        ros.executor.spin_once(timeout_sec=0)
        ros.executor.remove_node(node)
        node.destroy_node()
    watcher = ros.node("watcher")
    ros.wait_until(lambda: watcher.get_node_names() == ["watcher"])


def test_a_destroyed_node_owns_nothing(ros):
    node = Node("n", context=ros.context)
    publisher = node.create_publisher(Float64, "x", 1)
    node.create_subscription(Float64, "x", print, 1)
    node.create_client(Trigger, "s")
    node.create_service(Trigger, "s", print)
    node.create_timer(1.0, print)
    node.create_guard_condition(print)
    node.destroy_node()
    kinds = ("publishers", "subscriptions", "clients", "services", "timers", "guards")
    assert all(list(getattr(node, kind)) == [] for kind in kinds)
    with pytest.raises(InvalidHandle):
        publisher.publish(Float64())


@pytest.mark.parametrize("executor_class", [SingleThreadedExecutor, MultiThreadedExecutor])
def test_entities_come_and_go_while_another_thread_spins(ros, executor_class):
    node = Node("n", context=ros.context)
    executor = executor_class(context=ros.context)
    executor.add_node(node)
    spinner = threading.Thread(target=executor.spin)
    spinner.start()
    received = []
    for _ in range(50):
        publisher = node.create_publisher(Float64, "x", 10)
        subscription = node.create_subscription(Float64, "x", received.append, 10)
        timer = node.create_timer(0.0001, lambda: None)
        publisher.publish(Float64())
        node.destroy_subscription(subscription)
        node.destroy_timer(timer)
        node.destroy_publisher(publisher)
    executor.shutdown()
    spinner.join(20)
    assert not spinner.is_alive()
    node.destroy_node()


def test_nodes_come_and_go_while_another_thread_spins(ros):
    spinner = threading.Thread(target=ros.executor.spin)
    spinner.start()
    for index in range(10):
        node = Node(f"n{index}", context=ros.context)
        ros.executor.add_node(node)
        node.create_timer(0.0001, lambda: None)
        ros.executor.remove_node(node)
        node.destroy_node()
    ros.executor.shutdown()
    spinner.join(20)
    assert not spinner.is_alive()


def test_a_callback_may_destroy_its_own_node(ros):
    node = Node("n", context=ros.context)
    executor = SingleThreadedExecutor(context=ros.context)
    executor.add_node(node)
    calls = []

    def destroy():
        calls.append(1)
        node.destroy_node()

    node.create_timer(0.0, destroy)
    executor.spin_once(timeout_sec=20)
    executor.remove_node(node)
    executor.spin_once(timeout_sec=0.01)
    assert calls == [1]
    executor.shutdown()


def test_the_context_may_end_while_threads_spin():
    context = Context()
    context.init(args=[])
    outcomes = []

    def spin(executor):
        try:
            executor.spin()
            outcomes.append("returned")
        except ExternalShutdownException:
            outcomes.append("shut down")

    executors = [SingleThreadedExecutor(context=context) for _ in range(3)]
    nodes = [Node(f"n{index}", context=context) for index in range(3)]
    for node, executor in zip(nodes, executors, strict=True):
        executor.add_node(node)
    spinners = [threading.Thread(target=spin, args=[executor]) for executor in executors]
    for spinner in spinners:
        spinner.start()
    context.shutdown()
    for spinner in spinners:
        spinner.join(20)
    assert len(outcomes) == 3
    for node in nodes:
        node.destroy_node()


def test_many_contexts_leave_no_files_open():
    def life():
        context = Context()
        context.init(args=[])
        node = Node("n", context=context)
        node.destroy_node()
        context.shutdown()

    life()
    before = len(os.listdir("/proc/self/fd"))  # noqa: PTH208 - one number
    for _ in range(10):
        life()
    # Not even one file a context.
    assert len(os.listdir("/proc/self/fd")) < before + 10  # noqa: PTH208 - one number


def test_a_destroyed_node_has_no_name(ros):
    node = ros.node("n")
    timer = node.create_timer(1.0, print)
    node.destroy_node()
    for ask in (
        node.get_name,
        node.get_namespace,
        node.get_fully_qualified_name,
        node.get_node_names,
        lambda: node.resolve_topic_name("x"),
        lambda: node.create_publisher(Float64, "x", 1),
        timer.is_ready,
    ):
        with pytest.raises(InvalidHandle):
            ask()
    assert node.get_logger().name == "n"
    assert timer.handle is not None


def test_only_what_a_node_has_is_destroyed_by_it(node):
    for what in ("publisher", "subscription", "client", "service", "timer", "guard_condition"):
        assert not getattr(node, f"destroy_{what}")(5)
