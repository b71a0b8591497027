"""Simulated time has one source: what a plant does about another publisher of its clock."""

import time

from rclpy.node import Node
from rclpy.publisher import Publisher

PATIENCE = 5.0
"""Wall time [s] that a plant that runs gives a newcomer, which should refuse to start, to go."""

LOOK_PERIOD = 0.2
"""Wall time [s] from the start to the first look at who else is there, and between two looks."""


class ClockOwner:
    """Watches for other publishers of the clock.

    Parameters
    ----------
    node : rclpy.node.Node
        The plant.
    publisher : rclpy.publisher.Publisher
        Its publisher of the clock.

    Attributes
    ----------
    is_established : bool
        Whether it has looked and was alone, so that time may begin.
    """

    def __init__(self, node: Node, publisher: Publisher) -> None:
        self._node = node
        self._topic = publisher.topic_name
        self._disturbed_since: float | None = None
        self.is_established = False

    def look(self) -> str | None:
        """Return why this plant has to end: a clock with another source; None to go on."""
        others = self._other_publishers()
        if not others:
            self.is_established = True
            self._disturbed_since = None
            return None
        fault = (
            f"{self._node.get_fully_qualified_name()}: {self._topic} is published by "
            f"{', '.join(others)}, too: stop one of them, or let every node of this loop have a "
            "clock of its own with -r /clock:=clock in a namespace"
        )
        if not self.is_established:
            return fault
        if self._disturbed_since is None:
            self._disturbed_since = time.monotonic()
            self._node.get_logger().warning(f"this plant ends in {PATIENCE:g} s: {fault}")
        return fault if time.monotonic() - self._disturbed_since > PATIENCE else None

    def _other_publishers(self) -> list[str]:
        own = self._node.get_fully_qualified_name()
        names = [
            f"{info.node_namespace.rstrip('/')}/{info.node_name}"
            for info in self._node.get_publishers_info_by_topic(self._topic)
        ]
        if own in names:
            names.remove(own)
        return sorted(names)
