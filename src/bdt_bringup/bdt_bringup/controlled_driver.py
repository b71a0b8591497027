"""Driver and controller in one process: a measurement and its command do not leave it.

The nodes are those of their packages, with all their topics, services and parameters. Twin and
recorder, which nothing waits for in real time, keep processes of their own.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter

from bdt_bringup.hand_over import HandOver, handing_node
from bdt_bringup.installed import node_class
from bdt_msgs_py.clock_check import USE_SIM_TIME
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.real_time import RealTimeSettings
from bdt_msgs_py.topics import COMMAND, CONTROLLER_NODE, DRIVER_NODE, MEASUREMENT


class ControlledDriver:
    """Makes the two nodes.

    The controller listens to its driver alone. The driver listens to the topic, too: another
    controller may be the one that answers, as it may when each has a process of its own.
    """

    def __init__(self) -> None:
        self._hand_over = HandOver()

    def controller(
        self, *, parameter_overrides: Sequence[Parameter] = (), **node_arguments: Any
    ) -> Node:
        """Return the controller.

        It lives in wall time, as the drive does. How the process competes with others is said by
        the driver alone: a controller that collected garbage after its work would do so before
        the driver has done its own.

        Parameters
        ----------
        parameter_overrides : sequence of Parameter
            Values that go before those of the command line.
        **node_arguments
            Passed on to :class:`rclpy.node.Node`, as those of the driver are.
        """
        kind = self._kind(CONTROLLER_NODE, gives=COMMAND, takes=MEASUREMENT, hears_others=False)
        values = {f"real_time.{name}": value for name, value in asdict(RealTimeSettings()).items()}
        values[USE_SIM_TIME] = False
        own = [Parameter(name, value=value) for name, value in values.items()]
        return kind(parameter_overrides=[*parameter_overrides, *own], **node_arguments)

    def driver(self, **node_arguments: Any) -> Node:
        """Return the driver."""
        kind = self._kind(DRIVER_NODE, gives=MEASUREMENT, takes=COMMAND, hears_others=True)
        return kind(**node_arguments)

    def _kind(self, name: str, **exchanged: Any) -> Callable[..., Node]:
        return handing_node(node_class(name), self._hand_over, **exchanged)


def main(args: list[str] | None = None) -> None:
    """Run both nodes; the console script ``controlled_driver``."""
    nodes = ControlledDriver()
    sys.exit(run_node(nodes.driver, args, beside=[nodes.controller]))


if __name__ == "__main__":
    main()
