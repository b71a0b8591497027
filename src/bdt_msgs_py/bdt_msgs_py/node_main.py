"""The main function of a node process: arguments, spinning, one-line errors, exit codes."""

import sys
from collections.abc import Callable
from typing import TypeVar

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from bdt_msgs_py.exit_codes import BAD_INPUT, FAILED, LoopError
from bdt_msgs_py.node_parameters import ConfigurationError

NodeType = TypeVar("NodeType", bound=Node)


def spin_until_finished(executor: SingleThreadedExecutor, node: Node) -> None:
    """Run the callbacks of a node until its future ``finished``, if it has one, is done."""
    finished: Future[None] | None = getattr(node, "finished", None)
    if finished is None:
        executor.spin()
        return
    executor.spin_until_future_complete(finished)
    if finished.done():
        finished.result()


def run_node(
    create: Callable[[], NodeType],
    args: list[str] | None,
    spin: Callable[[SingleThreadedExecutor, NodeType], None] = spin_until_finished,
) -> int:
    """Run one node until it finishes or a signal stops it.

    Parameters
    ----------
    create : callable
        Returns the node; called once rclpy is initialised. A node with an attribute ``finished``,
        a future, ends the process when that is done; its exception says that the node failed.
    args : list of str or None
        Command line including ROS arguments; None for ``sys.argv``.
    spin : callable
        Runs the callbacks; gets the executor and the node.

    Returns
    -------
    int
        Exit code: 0 after the end or a signal, 1 when the loop failed, 2 for bad input.
    """
    try:
        rclpy.init(args=args)
    except RuntimeError as error:
        return _complain(str(error), BAD_INPUT)
    try:
        node = create()
    except ConfigurationError as error:
        rclpy.try_shutdown()
        return _complain(str(error), BAD_INPUT)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        spin(executor, node)
    except LoopError as error:
        return _complain(str(error), FAILED)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RuntimeError:
        # A signal may shut the context down while rclpy builds its wait set.
        if rclpy.ok():
            raise
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
    return 0


def _complain(reason: str, code: int) -> int:
    print("error: " + " ".join(reason.split()), file=sys.stderr)
    return code
