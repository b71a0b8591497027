"""A hidden node for the time of a command."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager

import rclpy
from rclpy.node import Node

__all__ = ["add_spin_time", "command_node", "is_hidden", "spin_for"]

#: How long to listen for the graph; peers on this machine answer in a tenth of it.
DEFAULT_SPIN_TIME = 0.5


def add_spin_time(parser: object) -> None:
    """Add the option that says how long to listen for the graph."""
    parser.add_argument(  # type: ignore[attr-defined]
        "--spin-time",
        type=float,
        default=DEFAULT_SPIN_TIME,
        help="Spin time in seconds to wait for discovery",
    )


@contextmanager
def command_node(spin_time: float = 0.0) -> Iterator[Node]:
    """Make a node, listen for the graph for a while, and destroy it in the end."""
    rclpy.init(args=[])
    node = rclpy.create_node(
        f"_ros2cli_{os.getpid()}", enable_rosout=False, start_parameter_services=False
    )
    try:
        spin_for(node, spin_time)
        yield node
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def spin_for(node: Node, seconds: float) -> None:
    """Run the callbacks of a node for a time."""
    end = time.monotonic() + seconds
    while rclpy.ok() and (left := end - time.monotonic()) > 0:
        rclpy.spin_once(node, timeout_sec=left)


def is_hidden(name: str) -> bool:
    """Whether a part of a name begins with an underscore."""
    return any(part.startswith("_") for part in name.split("/"))
