"""One end of a transport benchmark, as a process of its own: ``python -m ... ROLE [NUMBER]``.

Every role prints one line of JSON when it is done, after a line ``ready`` where another end waits
for it. Nothing but public rclpy is used, so this measures whichever rclpy is installed.
"""

import array
import json
import sys
import time
from collections.abc import Callable, Mapping
from operator import attrgetter
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from bdt_msgs_py.topics import PLATFORM_JOINT

DEPTH = 10
"""History of the ping-pong: reliable, as measurement and command."""

RESEND_PERIOD = 1.0
"""Wall time without an answer after which a message is sent again [s]."""

KEEP_ALL = QoSProfile(history=HistoryPolicy.KEEP_ALL)
"""Reliable without a limit: a writer waits for a reader that is behind."""


def main() -> None:
    """Run the role that the command line names."""
    role, *numbers = sys.argv[1:]
    rclpy.init()
    node = Node(f"bench_{role}", start_parameter_services=False)
    try:
        ROLES[role](node, *map(int, numbers))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass  # the other end is done
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def ping(node: Node, count: int) -> None:
    """Send a JointState, wait for its echo, and so on.

    A message is sent again until it is answered. One end may know the other before the other
    knows it: the first answers then go nowhere, however reliable the topic is.
    """
    publisher = node.create_publisher(JointState, "ping", DEPTH)
    answered = -1

    def note_answer(message: JointState) -> None:
        nonlocal answered
        answered = max(answered, message.header.stamp.sec)

    node.create_subscription(JointState, "pong", note_answer, DEPTH)
    _wait_until(node, lambda: publisher.get_subscription_count() > 0)
    _wait_until(node, lambda: node.count_publishers("pong") > 0)
    message = _joint_state()
    begun = cpu = 0.0
    for number in range(count // 10 + count):
        if number == count // 10:  # the first ones find the path
            begun, cpu = time.perf_counter(), time.process_time()
        message.header.stamp.sec = number
        while answered < number:
            publisher.publish(message)
            resend = time.monotonic() + RESEND_PERIOD
            while answered < number and time.monotonic() < resend:
                rclpy.spin_once(node, timeout_sec=RESEND_PERIOD)
    _report(seconds=time.perf_counter() - begun, cpu=time.process_time() - cpu)


def echo(node: Node) -> None:
    """Return every JointState until a signal comes."""
    publisher = node.create_publisher(JointState, "pong", DEPTH)
    node.create_subscription(JointState, "ping", publisher.publish, DEPTH)
    print("ready", flush=True)
    rclpy.spin(node)


def send(node: Node, count: int, numbers: int) -> None:
    """Send messages as fast as the reader takes them: JointState, or arrays of `numbers`.

    Empty messages come first, until the reader says that it hears them.
    """
    kind, message = _payload(numbers)
    publisher = node.create_publisher(kind, "stream", KEEP_ALL)
    heard = False

    def note_reader(_message: JointState) -> None:
        nonlocal heard
        heard = True

    node.create_subscription(JointState, "heard", note_reader, DEPTH)
    while not heard:
        publisher.publish(kind())
        rclpy.spin_once(node, timeout_sec=RESEND_PERIOD / 10)
    cpu = time.process_time()
    for _ in range(count):
        publisher.publish(message)
    cpu = time.process_time() - cpu
    _wait_until(node, lambda: publisher.get_subscription_count() == 0)
    _report(cpu=cpu)


def take(node: Node, count: int, numbers: int) -> None:
    """Take messages until there were enough."""
    kind, _ = _payload(numbers)
    content = attrgetter("data" if numbers else "name")
    taken = 0
    begun = cpu = 0.0
    heard = node.create_publisher(JointState, "heard", DEPTH)

    def count_one(message: Any) -> None:
        nonlocal taken, begun, cpu
        if not content(message):
            heard.publish(JointState())
            return
        if not taken:
            begun, cpu = time.perf_counter(), time.process_time()
        taken += 1

    node.create_subscription(kind, "stream", count_one, KEEP_ALL)
    print("ready", flush=True)
    while taken < count:
        rclpy.spin_once(node)
    _report(seconds=time.perf_counter() - begun, cpu=time.process_time() - cpu)


def watch(node: Node) -> None:
    """Print when a node named ``bench_appear`` shows in the graph."""
    print("ready", flush=True)
    _wait_until(node, lambda: "bench_appear" in node.get_node_names())
    _report(seen=time.time())


def appear(node: Node) -> None:
    """Exist until a signal comes."""
    rclpy.spin(node)


ROLES: Mapping[str, Callable[..., None]] = {
    function.__name__: function for function in (ping, echo, send, take, watch, appear)
}


def _joint_state() -> JointState:
    return JointState(name=[PLATFORM_JOINT], position=array.array("d", [0.005]))


def _payload(numbers: int) -> tuple[Any, Any]:
    if not numbers:
        return JointState, _joint_state()
    return Float64MultiArray, Float64MultiArray(data=array.array("d", bytes(8 * numbers)))


def _wait_until(node: Node, condition: Callable[[], bool]) -> None:
    while not condition():
        rclpy.spin_once(node, timeout_sec=0.001)


def _report(**numbers: float) -> None:
    print(json.dumps(numbers), flush=True)


if __name__ == "__main__":
    main()
