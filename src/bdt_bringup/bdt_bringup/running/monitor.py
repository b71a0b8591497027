"""What `bdt run` shows while the loop runs: simulated time, gap estimate, dead zone."""

import time
from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp, read_position
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    CLOCK,
    DEAD_ZONE_PARAMETER,
    GAP_JOINT,
    PARAMETER_EVENTS,
)


class MonitorNode(Node):
    """Listens to the loop.

    Attributes
    ----------
    simulated_time : float
        Latest simulated time [s].
    gap : float or None
        Latest estimate of the gap [rad].
    dead_zone : float or None
        Dead-zone tolerance in force [m].
    """

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__("monitor", **node_arguments)
        self.simulated_time = 0.0
        self.gap: float | None = None
        self.dead_zone: float | None = None
        self._begin: tuple[float, float] | None = None
        self._heard = 0.0
        for kind, topic, callback in (
            (Clock, CLOCK, self._take_clock),
            (JointState, BACKLASH_ESTIMATE, self._take_estimate),
            (ParameterEvent, PARAMETER_EVENTS, self._take_parameter_event),
        ):
            self.create_subscription(kind, topic.name, callback, qos_profile(topic))

    def real_time_factor(self) -> float | None:
        """Return simulated seconds per second of wall time until the latest of /clock."""
        if self._begin is None:
            return None
        wall, simulated = self._begin
        elapsed = self._heard - wall
        return (self.simulated_time - simulated) / elapsed if elapsed > 0 else None

    def _take_clock(self, message: Clock) -> None:
        self.simulated_time = nanoseconds_from_stamp(message.clock) * 1e-9
        self._heard = time.monotonic()
        if self._begin is None and self.simulated_time > 0:
            self._begin = self._heard, self.simulated_time

    def _take_estimate(self, message: JointState) -> None:
        _, self.gap = read_position(message, GAP_JOINT)

    def _take_parameter_event(self, message: ParameterEvent) -> None:
        for parameter in (*message.new_parameters, *message.changed_parameters):
            if parameter.name == DEAD_ZONE_PARAMETER:
                self.dead_zone = parameter.value.double_value
