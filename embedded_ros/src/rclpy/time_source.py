"""Simulated time for the clocks of a node."""

import weakref
from typing import Any, Final

from embedded_ros.own_warnings import Complaints
from embedded_ros.simulated_time import SimulatedTime
from rclpy._node_entities import NodeEntities
from rclpy.clock import ROSClock
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from rclpy.time import Time

__all__ = ["CLOCK_TOPIC", "USE_SIM_TIME_NAME", "TimeSource"]

CLOCK_TOPIC: Final = "/clock"
USE_SIM_TIME_NAME: Final = "use_sim_time"


class TimeSource:
    """Sets clocks from ``/clock`` while the node's parameter ``use_sim_time`` is true."""

    def __init__(self, *, node: Any = None) -> None:
        self._simulation = SimulatedTime()
        self._complaints = Complaints()
        self._listening: Subscription | None = None
        # The node holds its time source.
        self._host: weakref.ref[Any] | None = None
        if node is not None:
            self.attach_node(node)

    @property
    def ros_time_is_active(self) -> bool:
        """Whether the clocks show simulated time."""
        return self._simulation.is_shown

    @ros_time_is_active.setter
    def ros_time_is_active(self, enabled: bool) -> None:
        if enabled != self._simulation.is_shown:
            self._simulation.show(enabled)
            self._listen(enabled)

    @property
    def _node(self) -> Any:
        return None if self._host is None else self._host()

    def _listen(self, on: bool) -> None:
        from rosgraph_msgs.msg import Clock

        node = self._node
        if node is None:
            return
        if self._listening is not None:
            node.destroy_subscription(self._listening)
            self._listening = None
        if on:
            latest = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
            self._listening = node.create_subscription(
                Clock, CLOCK_TOPIC, self.clock_callback, latest
            )

    def attach_node(self, node: Any) -> None:
        """Follow a node's parameter, which is declared if need be."""
        if not isinstance(node, NodeEntities):
            raise TypeError("Node must be of type rclpy.node.Node")
        self.detach_node()
        self._host = weakref.ref(node)
        if not node.has_parameter(USE_SIM_TIME_NAME):
            node.declare_parameter(USE_SIM_TIME_NAME, False)
        given = node.get_parameter(USE_SIM_TIME_NAME)
        if given.type_ is Parameter.Type.BOOL:
            self.ros_time_is_active = given.value
            self._listen(given.value)
        elif given.type_ is not Parameter.Type.NOT_SET:
            text = f"Invalid type for parameter '{USE_SIM_TIME_NAME}' {given.type_!r}"
            node.get_logger().error(f"{text} should be bool")
        node.add_on_set_parameters_callback(self._judge)

    def detach_node(self) -> None:
        """Leave the node: clocks keep what they show, and nobody tells them the time."""
        node = self._node
        if node is not None:
            self._listen(False)
            node.remove_on_set_parameters_callback(self._judge)
        self._host = None

    def attach_clock(self, clock: ROSClock) -> None:
        """Set a clock from now on."""
        if not isinstance(clock, ROSClock):
            raise ValueError("Only clocks with type ROS_TIME can be attached.")
        self._simulation.drive(clock._timeline)

    def clock_callback(self, msg: Any) -> None:
        """Take a message of ``/clock``; a stamp before the epoch is left out with a warning.

        Anybody may write to the topic, and no node must die of it.
        """
        try:
            now = Time.from_msg(msg.clock)
        except ValueError as error:
            self._complaints.add(f"a message on {CLOCK_TOPIC} is left out: {error}")
        else:
            self._simulation.tell(now.nanoseconds)

    def _judge(self, parameters: list[Parameter]) -> Any:
        """Accept a new value of the parameter if it is a boolean, and follow it."""
        from rcl_interfaces.msg import SetParametersResult

        wishes = [each for each in parameters if each.name == USE_SIM_TIME_NAME]
        for wish in wishes:
            if wish.type_ is not Parameter.Type.BOOL:
                reason = f"{USE_SIM_TIME_NAME} parameter set to something besides a bool"
                self._node.get_logger().error(reason)
                return SetParametersResult(successful=False, reason=reason)
            self.ros_time_is_active = wish.value
        return SetParametersResult(successful=True)
