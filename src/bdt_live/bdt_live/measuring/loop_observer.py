"""Tells once a second how long a loop takes from a measurement to its command, and does no more.

``python -m bdt_live.measuring.loop_observer --ros-args ...`` prints that time [s], a line a second.
"""

import sys
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from sensor_msgs.msg import JointState

from bdt_live.loop_timing import LoopTiming
from bdt_msgs_py.message_checks import check_stamp
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import COMMAND, MEASUREMENT

PERIOD = 1.0
"""Wall time [s] between two lines."""

MOST = 2000
"""Latencies of which a line has the median: all of a second."""


class LoopObserver(Node):
    """Hears measurements and commands, for ``bdt bench live``.

    Parameters
    ----------
    **node_arguments
        Passed on to :class:`rclpy.node.Node`.
    """

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__("loop_observer", **node_arguments)
        self._timing = LoopTiming(MOST)

        def measured(message: Any, info: dict[str, int]) -> None:
            self._timing.measured(check_stamp(message.header.stamp), info["source_timestamp"])

        def commanded(message: Any, info: dict[str, int]) -> None:
            self._timing.commanded(check_stamp(message.header.stamp), info["source_timestamp"])

        for topic, take in ((MEASUREMENT, measured), (COMMAND, commanded)):
            self.create_subscription(JointState, topic.name, take, qos_profile(topic))
        self.create_timer(PERIOD, self._tell, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _tell(self) -> None:
        if self._timing.latency is not None:
            print(self._timing.latency, flush=True)
        self._timing = LoopTiming(MOST)


if __name__ == "__main__":
    sys.exit(run_node(LoopObserver, None, is_configured=False))
