"""The process behind a page: ROS, apart from the server, so that the page never slows the loop.

``python -m bdt_bringup.child_node PARENT bdt_live.ros_process SOCKET OUTPUT MODE --ros-args ...``
where MODE is that of the loop, ``lockstep`` or ``realtime``.
"""

import socket
import sys
from pathlib import Path

from rclpy.executors import SingleThreadedExecutor

from bdt_live.channel import Channel
from bdt_live.live_node import LiveNode
from bdt_live.niceness import PAGE_NICENESS, let_others_go_first
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.spinning import spin_at_intervals_until


def spin_while_watched(executor: SingleThreadedExecutor, node: LiveNode) -> None:
    """Run callbacks until the process of the page is gone, or a signal comes."""
    spin_at_intervals_until(executor, node, lambda: node.is_alone)


def main(args: list[str] | None = None) -> None:
    """Run the node."""
    program, number, output, mode, *ros_arguments = sys.argv if args is None else args
    # Before there are other threads, which inherit it.
    let_others_go_first(0, PAGE_NICENESS)
    end = socket.socket(fileno=int(number))
    channel = Channel(end)
    try:
        sys.exit(
            run_node(
                lambda: LiveNode(channel, Path(output), spares_loop=mode == "realtime"),
                [program, *ros_arguments],
                spin=spin_while_watched,
                is_configured=False,
            )
        )
    finally:
        channel.close()


if __name__ == "__main__":
    main()
