"""What `bdt run` shows while the loop runs: simulated time, gap estimate, dead zone."""

import time
from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from bdt_bringup.loop_health import LoopHealth
from bdt_bringup.loop_state import LoopState
from bdt_msgs_py.clock_check import clock_sequence
from bdt_msgs_py.message_checks import check_clock, check_dead_zone, check_estimate
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.rejection import MessageRejectedError, RejectedMessages
from bdt_msgs_py.topics import (
    BACKLASH_ESTIMATE,
    CLOCK,
    CONTROLLER_NODE,
    DEAD_ZONE_PARAMETER,
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
    health : LoopHealth
        What the nodes of the loop say of themselves.
    rejected : RejectedMessages
        What is not shown, because it cannot be true.
    """

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__("monitor", **node_arguments)
        self.simulated_time = 0.0
        self.gap: float | None = None
        self.dead_zone: float | None = None
        self._begin: tuple[float, float] | None = None
        self._heard = 0.0
        self._times = clock_sequence()
        self.health = LoopHealth(self)
        self.rejected = RejectedMessages(self.get_logger())
        for kind, topic, callback in (
            (Clock, CLOCK, self._take_clock),
            (JointState, BACKLASH_ESTIMATE, self._take_estimate),
            (ParameterEvent, PARAMETER_EVENTS, self._take_parameter_event),
        ):
            self.create_subscription(kind, topic.name, callback, qos_profile(topic))

    @property
    def state(self) -> LoopState:
        """State of the loop, as its nodes say it."""
        return self.health.state

    def real_time_factor(self) -> float | None:
        """Return simulated seconds per second of wall time until the latest of /clock."""
        if self._begin is None:
            return None
        wall, simulated = self._begin
        elapsed = self._heard - wall
        return (self.simulated_time - simulated) / elapsed if elapsed > 0 else None

    def _take_clock(self, message: Clock) -> None:
        try:
            stamp = check_clock(message)
            self._times.check(stamp, time.monotonic())
        except MessageRejectedError as error:
            self.rejected.count(CLOCK, error)
            return
        self.simulated_time = stamp * 1e-9
        self._heard = time.monotonic()
        if self._begin is None and self.simulated_time > 0:
            self._begin = self._heard, self.simulated_time

    def _take_estimate(self, message: JointState) -> None:
        try:
            _, self.gap = check_estimate(message)
        except MessageRejectedError as error:
            self.rejected.count(BACKLASH_ESTIMATE, error)

    def _take_parameter_event(self, message: ParameterEvent) -> None:
        if message.node != f"{self.get_namespace().rstrip('/')}/{CONTROLLER_NODE}":
            return
        for parameter in (*message.new_parameters, *message.changed_parameters):
            if parameter.name == DEAD_ZONE_PARAMETER:
                try:
                    self.dead_zone = check_dead_zone(parameter.value)
                except MessageRejectedError as error:
                    self.rejected.count(PARAMETER_EVENTS, error)
