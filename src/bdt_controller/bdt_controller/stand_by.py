"""Two controllers of a loop: the later one stays silent while the other one answers."""

import time
from collections import deque

from rclpy.node import Node
from rclpy.subscription import Subscription
from sensor_msgs.msg import JointState

from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp
from bdt_msgs_py.sole_publisher import publisher_count
from bdt_msgs_py.topics import COMMAND

SILENCE = 0.5
"""Wall time [s] without a command of another node after which a controller takes over."""
MEMORY = 100
"""Newest measurements by which an answer is told from a stray."""


class StandBy:
    """Tells a controller whether somebody else answers the measurements.

    It looks once, when the first measurement comes. A publisher of commands that is there by then
    may be a controller that was killed, which the network has not forgotten yet: whether it is
    alive its commands tell.

    Parameters
    ----------
    node : rclpy.node.Node
        The controller.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._is_decided = False
        self._subscription: Subscription | None = None
        self._stamps: deque[int] = deque(maxlen=MEMORY)
        self._heard_at = 0.0
        self._has_told = False

    @property
    def is_on(self) -> bool:
        """Whether to stay silent, as far as is known."""
        return self._subscription is not None

    def look(self, stamp: int) -> bool:
        """Tell, when a measurement of a stamp [ns] has come, whether to stay silent."""
        self._stamps.append(stamp)
        now = time.monotonic()
        if not self._is_decided:
            self._is_decided = True
            if publisher_count(self._node, COMMAND) > 1:
                self._heard_at = now
                self._subscription = self._node.create_subscription(
                    JointState, COMMAND.name, self._hear, qos_profile(COMMAND)
                )
        if self._subscription is not None and now - self._heard_at >= SILENCE:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None
            if self._has_told:
                self._node.get_logger().warning("the other controller is silent: taking over")
        return self.is_on

    def _hear(self, command: JointState) -> None:
        # Whoever answers no measurement is a stray, and no controller.
        if nanoseconds_from_stamp(command.header.stamp) not in self._stamps:
            return
        self._heard_at = time.monotonic()
        if not self._has_told:
            self._has_told = True
            self._node.get_logger().warning("another controller answers: standing by")
