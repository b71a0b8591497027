"""Contexts: beginning, end, and ends in any order."""

import itertools
import os
import subprocess
import sys
import threading

import pytest
import rclpy
from rclpy._rclpy_pybind11 import RCLError
from rclpy.context import Context
from rclpy.exceptions import NotInitializedException
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Float64


def test_a_context_lives_from_init_to_shutdown():
    context = Context()
    assert not context.ok()
    context.init(args=[])
    assert context.ok()
    assert context.get_domain_id() == int(os.environ["ROS_DOMAIN_ID"])
    with pytest.raises(RuntimeError, match="must only be called once"):
        context.init(args=[])
    context.shutdown()
    assert not context.ok()
    context.try_shutdown()
    with pytest.raises(RCLError, match="already called"):
        context.shutdown()


def test_the_default_context_is_replaced_after_shutdown():
    rclpy.init(args=[])
    assert rclpy.ok()
    node = rclpy.create_node("n")
    future = rclpy.get_global_executor().create_task(lambda: 1)
    rclpy.spin_until_future_complete(node, future, timeout_sec=5)
    assert future.result() == 1
    node.destroy_node()
    rclpy.shutdown()
    assert not rclpy.ok()
    rclpy.init(args=[])
    assert rclpy.ok()
    rclpy.try_shutdown()
    rclpy.try_shutdown()
    assert not rclpy.ok()


def test_a_context_manager_does_both():
    with Context() as context:
        assert context.ok()
    assert not context.ok()


def test_shutdown_calls_back(ros):
    calls = []
    ros.context.on_shutdown(lambda: calls.append(ros.context.ok()))
    ros.context.shutdown()
    assert calls == [False]
    ros.context.on_shutdown(lambda: calls.append("at once"))
    assert calls == [False, "at once"]


def test_without_init_there_are_no_nodes():
    with pytest.raises(NotInitializedException):
        Node("n", context=Context())
    with pytest.raises(RuntimeError):
        Context().shutdown()
    with pytest.raises(RuntimeError):
        Context().get_domain_id()
    with pytest.raises(RuntimeError, match="lower than zero"):
        Context().init(args=[], domain_id=-1)


@pytest.mark.parametrize(("value", "text"), [("x", "integral number"), ("233", "out of range")])
def test_a_bad_domain_in_the_environment_is_named(monkeypatch, value, text):
    monkeypatch.setenv("ROS_DOMAIN_ID", value)
    with pytest.raises(RCLError, match=f"ROS_DOMAIN_ID is.*{text}.*{value}"):
        Context().init(args=[])


def test_a_bad_configuration_of_cyclone_is_named(monkeypatch):
    monkeypatch.setenv("CYCLONEDDS_URI", "<nonsense/>")
    with pytest.raises(RCLError, match="nonsense"):
        Context().init(args=[], domain_id=(int(os.environ["ROS_DOMAIN_ID"]) % 100) + 1)


def test_domains_do_not_hear_each_other(ros):
    other = Context()
    other.init(args=[], domain_id=(ros.context.get_domain_id() % 100) + 1)
    here, there = Node("here", context=ros.context), Node("there", context=other)
    there.create_subscription(Float64, "/x", print, 10)
    publisher = here.create_publisher(Float64, "/x", 10)
    assert not here.wait_for_node("/there", 0.3)
    assert publisher.get_subscription_count() == 0
    here.destroy_node()
    there.destroy_node()
    other.shutdown()


def test_two_contexts_in_a_process_find_each_other(ros):
    other = Context()
    other.init(args=[])
    first, second = Node("first", context=ros.context), Node("second", context=other)
    assert first.wait_for_node("/second", 5)
    second.destroy_node()
    other.shutdown()
    first.destroy_node()


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


def test_nothing_is_left_behind():
    def open_files():
        return len(os.listdir("/proc/self/fd"))  # noqa: PTH208 - one number

    def life():
        context = Context()
        context.init(args=[])
        nodes = [Node(f"n{index}", context=context) for index in range(5)]
        for node in nodes:
            node.destroy_node()
        context.shutdown()

    life()
    threads, files = threading.active_count(), open_files()
    native = len(os.listdir("/proc/self/task"))  # noqa: PTH208 - one number
    for _ in range(5):
        life()
    assert threading.active_count() <= threads
    assert open_files() <= files
    assert len(os.listdir("/proc/self/task")) <= native  # noqa: PTH208 - one number


LEAVING = """
import sys, threading
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
if how == "spinning daemon":
    node.create_timer(0.0001, lambda: publisher.publish(Float64()))
    threading.Thread(target=executor.spin, daemon=True).start()
elif how == "exception":
    raise SystemExit(5)
elif how == "cycle":
    node.me = node
    del node, executor, publisher
print("leaves")
"""


@pytest.mark.parametrize(
    ("how", "code"), [("plain", 0), ("spinning daemon", 0), ("exception", 5), ("cycle", 0)]
)
def test_a_program_may_end_without_cleaning_up(how, code):
    done = subprocess.run(
        [sys.executable, "-c", LEAVING, how],
        capture_output=True,
        text=True,
        timeout=20,
        check=False,
    )
    assert done.returncode == code
    assert done.stderr == ""


def test_many_nodes_come_and_go(ros):
    for index in range(100):
        node = Node(f"n{index}", context=ros.context, start_parameter_services=False)
        node.create_timer(1.0, lambda: None)
        ros.executor.add_node(node)
        ros.executor.spin_once(timeout_sec=0)
        ros.executor.remove_node(node)
        node.destroy_node()
    watcher = ros.create(Node, "watcher")
    assert watcher.get_node_names() == ["watcher"]
