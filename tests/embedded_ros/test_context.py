"""Contexts: errors that name their cause, and ends that rclpy does not survive."""

import json
import os
import subprocess
import sys
import threading

import pytest
from rclpy._rclpy_pybind11 import RCLError
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


def test_callbacks_of_the_shutdown_may_ask_the_context(ros):
    # rclpy 7.1 waits for ever here.
    calls = []
    ros.context.on_shutdown(lambda: calls.append(ros.context.ok()))
    ros.context.shutdown()
    assert calls == [False]


@pytest.mark.parametrize(("value", "text"), [("x", "integral number"), ("233", "out of range")])
def test_a_bad_domain_in_the_environment_is_named(monkeypatch, value, text):
    monkeypatch.setenv("ROS_DOMAIN_ID", value)
    with pytest.raises(RCLError, match=f"ROS_DOMAIN_ID is.*{text}.*{value}"):
        Context().init(args=[])


def test_a_bad_configuration_of_cyclone_is_named(monkeypatch):
    monkeypatch.setenv("CYCLONEDDS_URI", "<nonsense/>")
    with pytest.raises(RCLError, match="nonsense"):
        Context().init(args=[], domain_id=(int(os.environ["ROS_DOMAIN_ID"]) % 100) + 1)


LIVES = """
import os, threading
from rclpy.context import Context
from rclpy.node import Node

def held():
    folders = "/proc/self/fd", "/proc/self/task"
    return [threading.active_count(), *(len(os.listdir(folder)) for folder in folders)]

def life():
    context = Context()
    context.init(args=[])
    nodes = [Node(f"n{index}", context=context) for index in range(5)]
    for node in nodes:
        node.destroy_node()
    context.shutdown()

life()
before = held()
for _ in range(5):
    life()
print([after - one for after, one in zip(held(), before, strict=True)])
"""


def test_nothing_is_left_behind():
    """Threads, descriptors and threads of the system, in a process with nothing else in it."""
    ended = subprocess.run(
        [sys.executable, "-c", LIVES], capture_output=True, text=True, check=True
    )
    assert all(more <= 0 for more in json.loads(ended.stdout)), ended.stdout


@pytest.mark.parametrize("place", ["text", "file"])
def test_the_environment_may_choose_interfaces(monkeypatch, tmp_path, place):
    interfaces = '<Interfaces><NetworkInterface name="lo" multicast="false"/></Interfaces>'
    configuration = f"<CycloneDDS><Domain><General>{interfaces}</General></Domain></CycloneDDS>"
    if place == "file":
        path = tmp_path / "cyclone.xml"
        path.write_text(configuration)
        configuration = f"file://{path}"
    monkeypatch.setenv("CYCLONEDDS_URI", configuration)
    context = Context()
    context.init(args=[], domain_id=(int(os.environ["ROS_DOMAIN_ID"]) % 100) + 1)
    assert context.ok()
    context.shutdown()


LEAVING = """
import threading
import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import Float64
rclpy.init(args=[])
node = rclpy.create_node("n")
publisher = node.create_publisher(Float64, "x", 10)
node.create_subscription(Float64, "x", lambda msg: None, 10)
executor = SingleThreadedExecutor()
executor.add_node(node)
node.create_timer(0.0001, lambda: publisher.publish(Float64()))
threading.Thread(target=executor.spin, daemon=True).start()
print("leaves")
"""


def test_a_program_may_end_while_a_daemon_thread_spins():
    # It makes rclpy 7.1 abort.
    done = subprocess.run(
        [sys.executable, "-c", LEAVING],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "leaves\n", "")


def test_a_multi_threaded_executor_leaves_no_thread_behind(ros):
    # That of rclpy 7.1 keeps its pool.
    before = threading.active_count()
    executor = MultiThreadedExecutor(2, context=ros.context)
    node = ros.create(Node, "n")
    executor.add_node(node)
    node.create_guard_condition(lambda: None).trigger()
    executor.spin_once(timeout_sec=1)
    executor.shutdown()
    ros.spin_until(lambda: threading.active_count() <= before)
