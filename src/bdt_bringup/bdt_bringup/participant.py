"""A node of this program's own that takes part in a ROS graph for as long as it is needed."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.loop_namespace import namespace_arguments

AnyNode = TypeVar("AnyNode", bound=Node)


@contextmanager
def participant(
    create_node: Callable[..., AnyNode], namespace: str
) -> Iterator[tuple[AnyNode, SingleThreadedExecutor]]:
    """Create a node with an executor in a context of its own, and end all of them.

    Signals are left to the program.

    Parameters
    ----------
    create_node : callable
        Class of the node; called with ``context`` and ``cli_args``.
    namespace : str
        From :func:`bdt_msgs_py.loop_namespace.full_namespace`.

    Yields
    ------
    node, executor
        The executor has the node and no other.

    Raises
    ------
    BadInputError
        If there can be no such node, for example for a ROS_DOMAIN_ID that is none.
    """
    context = Context()
    try:
        rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        raise BadInputError(" ".join(str(error).split())) from error
    executor = SingleThreadedExecutor(context=context)
    node = create_node(context=context, cli_args=["--ros-args", *namespace_arguments(namespace)])
    executor.add_node(node)
    try:
        yield node, executor
    finally:
        executor.shutdown()
        node.destroy_node()
        context.try_shutdown()
