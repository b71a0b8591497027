"""A hidden node for the time of a command, and what all commands ask of it."""

import argparse
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.exceptions import InvalidTopicNameException
from rclpy.executors import ExternalShutdownException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rclpy.validate_full_topic_name import validate_full_topic_name
from ros2cli.errors import CommandError

__all__ = [
    "add_group",
    "add_node_arguments",
    "command_node",
    "full_topic_name",
    "is_hidden",
    "spin_for",
    "spin_until",
    "wait_for_node_names",
]

#: How long to listen for the graph; peers on this machine answer in a tenth of it.
DEFAULT_SPIN_TIME = 0.5

#: How long to wait for names beyond that: rmw_fastrtps tells them with a heartbeat, every 3 s.
_NODE_NAMES_TIMEOUT_S = 4.0
_NO_NAMES = ("_CREATED_BY_BARE_DDS_APP_", "_NODE_NAME_UNKNOWN_")


def add_group(groups: Any, name: str, description: str) -> Any:
    """Add a command that has verbs; what verbs are added to."""
    parser = groups.add_parser(name, help=description, description=description)
    parser.set_defaults(parser=parser)
    return parser.add_subparsers(
        title="Commands", metavar=f"Call `ros2 {name} <command> -h` for more detailed usage."
    )


def add_node_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of each verb that asks the graph."""
    parser.add_argument(
        "--spin-time",
        type=float,
        default=DEFAULT_SPIN_TIME,
        metavar="SECONDS",
        help="Spin time in seconds to wait for discovery",
    )
    parser.add_argument(
        "--no-daemon", action="store_true", help="Spawn no daemon: this command never does"
    )


@contextmanager
def command_node(
    spin_time: float = 0.0,
    *,
    name: str | None = None,
    init_arguments: list[str] | None = None,
    use_sim_time: bool = False,
    signals: SignalHandlerOptions | None = None,
) -> Iterator[Node]:
    """Make a node, listen for the graph for a while, and destroy it in the end.

    Parameters
    ----------
    spin_time : float
        Seconds to listen.
    name : str, optional
        A hidden one by default.
    init_arguments : list of str, optional
        ROS arguments, such as remappings.
    use_sim_time : bool
    signals : SignalHandlerOptions, optional
        Those of :func:`rclpy.init`.

    Raises
    ------
    ExternalShutdownException
        In the end, if a signal has ended the context.
    """
    rclpy.init(args=init_arguments or [], signal_handler_options=signals)
    try:
        node = rclpy.create_node(
            name or f"_ros2cli_{os.getpid()}",
            enable_rosout=False,
            start_parameter_services=False,
            parameter_overrides=[Parameter("use_sim_time", value=use_sim_time)],
        )
        try:
            spin_for(node, spin_time)
            yield node
            if not rclpy.ok():
                # The signal came between two waits: the command ends as if it had come in one.
                raise ExternalShutdownException
        finally:
            node.destroy_node()
    finally:
        rclpy.try_shutdown()


def spin_for(node: Node, seconds: float) -> None:
    """Run the callbacks of a node for a time."""
    spin_until(node, lambda: False, seconds)


def spin_until(node: Node, condition: Callable[[], Any], seconds: float) -> bool:
    """Run the callbacks of a node until a condition is true; False if it is not in time."""
    end = time.monotonic() + seconds
    while rclpy.ok() and not condition():
        left = end - time.monotonic()
        if left <= 0:
            return False
        # What changes the graph wakes nobody, so look again soon.
        rclpy.spin_once(node, timeout_sec=min(left, 0.02))
    return True


def wait_for_node_names(node: Node) -> None:
    """Listen on until the names of all nodes have come that are seen by their parameter events."""
    spin_until(
        node,
        lambda: all(
            info.node_name not in _NO_NAMES
            for info in node.get_publishers_info_by_topic("/parameter_events")
        ),
        _NODE_NAMES_TIMEOUT_S,
    )


def full_topic_name(node: Node, topic: str) -> str:
    """Expanded name of a topic of the command line."""
    try:
        name: str = expand_topic_name(topic, node.get_name(), node.get_namespace())
        validate_full_topic_name(name)
    except (ValueError, InvalidTopicNameException) as error:
        raise CommandError(" ".join(str(error).split())) from None
    return name


def is_hidden(name: str) -> bool:
    """Whether a part of a name begins with an underscore."""
    return any(part.startswith("_") for part in name.split("/"))
