"""``ros2 doctor``: what runs here, over what it talks, and whether it works."""

import argparse
import os
import platform
import socket
import sys
import time
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from ros2cli.graph import is_hidden
from ros2cli.node_session import command_node

__all__ = ["doctor"]

_SKIPPED_TOPICS = ("/parameter_events", "/rosout")
_ROUND_TRIP_S = 5.0
_GRAPH_S = 0.5

#: A title, and names with values.
Report = tuple[str, list[tuple[str, Any]]]
#: Errors and warnings.
Findings = tuple[list[str], list[str]]


def doctor(arguments: argparse.Namespace) -> None:
    """``doctor`` and ``wtf``."""
    if arguments.report:
        for _, _, report in _EXAMINATIONS:
            _print(report())
        return
    failed = []
    for name, check, report in _EXAMINATIONS:
        errors, warnings = check()
        for text in errors:
            print(f"ERROR: {text}", file=sys.stderr)
        for text in warnings:
            print(f"UserWarning: {text}", file=sys.stderr)
        if errors or (warnings and arguments.include_warnings):
            failed.append((name, report))
    if failed:
        print(f"\n{len(failed)}/{len(_EXAMINATIONS)} check(s) failed\n")
        print("Failed modules:", *(name for name, _ in failed))
    else:
        print(f"\nAll {len(_EXAMINATIONS)} checks passed\n")
    if arguments.report_failed:
        for _, report in failed:
            _print(report())


def _print(report: Report) -> None:
    title, items = report
    width = max((len(name) + 4 for name, _ in items), default=8)
    print(f"\n   {title}")
    for name, value in items:
        print(f"{name:<{width}}: {value}")


# ------------------------------------------------------------------ runtime


def _is_embedded() -> bool:
    return find_spec("embedded_ros") is not None


def _version(distribution: str) -> str:
    try:
        return version(distribution)
    except PackageNotFoundError:
        return "unknown"


def _runtime_report() -> Report:
    runtime = f"ROS 2 {os.environ.get('ROS_DISTRO', '(ROS_DISTRO is not set)')}"
    if _is_embedded():
        runtime = f"embedded_ros {_version('embedded-ros')}"
    return "RUNTIME", [
        ("runtime", runtime),
        ("rclpy", os.path.dirname(rclpy.__file__)),  # noqa: PTH120 - a path to be read
        ("python", f"{platform.python_version()} ({sys.executable})"),
        ("system", platform.platform()),
    ]


def _check_runtime() -> Findings:
    if _is_embedded() and os.environ.get("AMENT_PREFIX_PATH"):
        prefixes = os.environ["AMENT_PREFIX_PATH"]
        return [], [f"embedded_ros runs where a ROS 2 is sourced ({prefixes})."]
    return [], []


# -------------------------------------------------------------- middleware


def _middleware_report() -> Report:
    items: list[tuple[str, Any]] = [("middleware name", rclpy.get_rmw_implementation_identifier())]
    if _is_embedded():
        items.append(("transport", f"Cyclone DDS {_version('cyclonedds')} from PyPI"))
    return "RMW MIDDLEWARE", items


def _check_middleware() -> Findings:
    """Send a message between two participants: discovery and data, over the real transport."""
    from std_msgs.msg import String

    contexts = (Context(), Context())
    heard: list[str] = []
    nodes: list[Node] = []
    executor: SingleThreadedExecutor | None = None
    topic = f"/_ros2cli_doctor_{os.getpid()}"
    try:
        for context in contexts:
            rclpy.init(args=[], context=context)
            nodes.append(rclpy.create_node("_ros2cli_doctor", context=context, enable_rosout=False))
        publisher = nodes[0].create_publisher(String, topic, 1)
        nodes[1].create_subscription(String, topic, lambda message: heard.append(message.data), 1)
        executor = SingleThreadedExecutor(context=contexts[1])
        executor.add_node(nodes[1])
        end = time.monotonic() + _ROUND_TRIP_S
        while not heard and time.monotonic() < end:
            publisher.publish(String(data="hello"))
            executor.spin_once(timeout_sec=0.05)
    except RuntimeError as error:
        return [f"No node can be made: {error}"], []
    finally:
        if executor is not None:
            executor.shutdown()
        for node in nodes:
            node.destroy_node()
        for context in contexts:
            context.try_shutdown()
    return ([] if heard else [f"No message arrived within {_ROUND_TRIP_S:g} s."]), []


# ----------------------------------------------------------------- network


def _network_report() -> Report:
    default_range = "LOCALHOST" if _is_embedded() else "SUBNET"
    chosen = os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "")
    reach = (chosen or default_range).upper()
    configuration = os.environ.get("CYCLONEDDS_URI", "")
    peers = os.environ.get("ROS_STATIC_PEERS", "")
    if configuration:
        interface = "as CYCLONEDDS_URI says"
    elif reach in ("LOCALHOST", "OFF") and not peers:
        interface = "lo (this machine only)"
    else:
        interface = "chosen by the middleware"
    return "NETWORK CONFIGURATION", [
        ("domain id", os.environ.get("ROS_DOMAIN_ID") or "0 (default)"),
        ("discovery range", chosen or f"{default_range} (default)"),
        ("static peers", peers or "none"),
        ("interface", interface),
        ("CYCLONEDDS_URI", configuration or "not set"),
        ("interfaces here", ", ".join(name for _, name in socket.if_nameindex())),
    ]


def _check_network() -> Findings:
    names = [name for _, name in socket.if_nameindex()]
    if not any(name.startswith("lo") for name in names):
        return ["There is no loopback interface: nodes of this machine do not meet."], []
    return [], [] if len(names) > 1 else [
        "There is only a loopback interface: no other machine is heard."
    ]


# ------------------------------------------------------------------ topics


def _topic_counts() -> list[tuple[str, int, int]]:
    with command_node(_GRAPH_S) as node:
        return [
            (name, node.count_publishers(name), node.count_subscribers(name))
            for name, _ in node.get_topic_names_and_types()
            if name not in _SKIPPED_TOPICS and not is_hidden(name)
        ]


def _topic_report() -> Report:
    items: list[tuple[str, Any]] = []
    for name, publishers, subscriptions in _topic_counts() or [("none", 0, 0)]:
        items += [
            ("topic", name),
            ("publisher count", publishers),
            ("subscriber count", subscriptions),
        ]
    return "TOPIC LIST", items


def _check_topics() -> Findings:
    warnings = []
    for name, publishers, subscriptions in _topic_counts():
        if publishers and not subscriptions:
            warnings.append(f"{name} is published, and nobody subscribes.")
        elif subscriptions and not publishers:
            warnings.append(f"{name} is subscribed, and nobody publishes.")
    return [], warnings


_EXAMINATIONS: tuple[tuple[str, Callable[[], Findings], Callable[[], Report]], ...] = (
    ("runtime", _check_runtime, _runtime_report),
    ("middleware", _check_middleware, _middleware_report),
    ("network", _check_network, _network_report),
    ("topic", _check_topics, _topic_report),
)
