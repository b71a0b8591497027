"""The main function of a node process: arguments, spinning, one-line errors, exit codes."""

import sys
from collections.abc import Callable, Sequence
from typing import TypeVar

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from bdt_msgs_py.command_errors import BAD_INPUT, FAILED, BadInputError, LoopError, complain
from bdt_msgs_py.parameter_files import unused_files
from bdt_msgs_py.stop_signals import InterruptOfWork

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
    *,
    is_configured: bool = True,
    beside: Sequence[Callable[[], Node]] = (),
) -> int:
    """Run a node until it finishes or a signal stops it; the process is to end after that.

    Parameters
    ----------
    create : callable
        Returns the node; called once rclpy is initialised. A node with an attribute ``finished``,
        a future, ends the process when that is done; its exception says that the node failed.
    args : list of str or None
        Command line including ROS arguments; None for ``sys.argv``.
    spin : callable
        Runs the callbacks; gets the executor and the node.
    is_configured : bool
        Whether a parameter file without anything for the node is refused: it would run on
        defaults where somebody meant other values. False for a node that needs none of a loop's
        parameters, and only says that a file shared with the loop holds nothing for it.
    beside : sequence of callable
        Return further nodes of the process, which share the executor: made before the node,
        destroyed after it. A parameter file has to hold something for one of them.

    Returns
    -------
    int
        Exit code: 0 after the end or a signal, 1 when the loop failed, 2 for bad input.
    """
    interrupt = InterruptOfWork()
    try:
        rclpy.init(args=args)
    except RuntimeError as error:
        return complain(error, BAD_INPUT)
    executor = SingleThreadedExecutor()
    nodes: list[Node] = []
    try:
        try:
            # Piece by piece: what is there when one cannot be made is destroyed.
            nodes.extend(make() for make in beside)
            node = create()
            nodes.append(node)
            _check_parameter_files(nodes, sys.argv if args is None else args, is_configured)
            for each in nodes:
                executor.add_node(each)
            spin(executor, node)
        finally:
            interrupt.work_is_over()
    except LoopError as error:
        return complain(error, FAILED)
    except BadInputError as error:
        return complain(error, BAD_INPUT)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RuntimeError:
        # A signal may shut the context down while rclpy makes the node or builds its wait set.
        if rclpy.ok():
            raise
    finally:
        executor.shutdown()
        for each in reversed(nodes):
            each.destroy_node()
        rclpy.try_shutdown()
    return 0


def _check_parameter_files(
    nodes: Sequence[Node], arguments: Sequence[str], is_configured: bool
) -> None:
    lines = unused_files(arguments, *(node.get_fully_qualified_name() for node in nodes))
    if lines and is_configured:
        raise BadInputError(lines[0])
    for line in lines:
        nodes[-1].get_logger().warning(line)
