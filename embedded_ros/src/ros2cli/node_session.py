"""A hidden node for the time of a command, and waiting with it."""

import math
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.exceptions import NameValidationException
from rclpy.executors import ExternalShutdownException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rclpy.validate_full_topic_name import validate_full_topic_name
from ros2cli.errors import CommandError, Terminated

__all__ = ["command_node", "full_topic_name", "listen", "wait_until"]

#: A change of the graph wakes nobody, so look again this soon.
_LOOK_S = 0.02


@contextmanager
def command_node(
    listening: float = 0.0,
    *,
    name: str | None = None,
    ros_arguments: tuple[str, ...] = (),
    use_sim_time: bool = False,
    signals: SignalHandlerOptions | None = None,
) -> Iterator[Node]:
    """Make a node, listen for the graph with it, and destroy it in the end.

    Parameters
    ----------
    listening : float
        Seconds to hear of other nodes before the command goes on.
    name : str, optional
        A hidden one by default.
    ros_arguments : tuple of str
        Such as remappings: ``-r``, ``old:=new``.
    use_sim_time : bool
    signals : SignalHandlerOptions, optional
        Those of :func:`rclpy.init`.

    Raises
    ------
    CommandError
        If a name on the command line cannot be one of ROS.
    Terminated
        If SIGTERM has ended the context, be it between two waits.
    """
    rclpy.init(args=["--ros-args", *ros_arguments, "--"], signal_handler_options=signals)
    try:
        node = rclpy.create_node(
            name or f"_ros2cli_{os.getpid()}",
            enable_rosout=False,
            start_parameter_services=False,
            parameter_overrides=[Parameter("use_sim_time", value=use_sim_time)],
        )
        try:
            listen(node, listening)
            yield node
        finally:
            node.destroy_node()
        if not rclpy.ok():
            raise Terminated
    except ExternalShutdownException:
        raise Terminated from None
    except NameValidationException as error:
        # The last line only points at the character that is meant.
        raise CommandError("\n".join(str(error).splitlines()[:-1])) from None
    finally:
        rclpy.try_shutdown()


def listen(node: Node, seconds: float) -> None:
    """Run the callbacks of a node for a time."""
    wait_until(node, lambda: False, seconds)


def wait_until(node: Node, come_true: Callable[[], Any], seconds: float = math.inf) -> bool:
    """Run the callbacks of a node until something is true, and tell whether it became so."""
    deadline = time.monotonic() + seconds
    while not come_true():
        remaining = deadline - time.monotonic()
        if remaining <= 0 or not rclpy.ok():
            return False
        rclpy.spin_once(node, timeout_sec=min(remaining, _LOOK_S))
    return True


def full_topic_name(node: Node, topic: str) -> str:
    """Name of a topic from its first slash on, as the graph has it."""
    try:
        name: str = expand_topic_name(topic, node.get_name(), node.get_namespace())
    except ValueError as error:
        raise CommandError(error) from None
    validate_full_topic_name(name)
    return name
