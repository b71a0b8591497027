"""Whether the stamps of messages go with the clock of the node that takes them.

With ``use_sim_time`` and no simulated clock a node's time stands at zero: it works on what it gets,
and whatever it has put off to a later time never happens.
"""

from rclpy.node import Node

from bdt_msgs_py.clock_check import USE_SIM_TIME
from bdt_msgs_py.reading import NANOSECONDS_PER_SECOND
from bdt_msgs_py.topics import CLOCK

LARGEST_OFFSET = 60 * NANOSECONDS_PER_SECOND
"""Difference [ns] of stamps and clock that a queue or a pause can explain."""

PATIENCE = NANOSECONDS_PER_SECOND
"""Time [ns] that stamps go on before a clock that stands at zero counts as missing."""


class ClockAgreement:
    """Compares stamps with a node's clock, whenever somebody asks.

    Parameters
    ----------
    node : rclpy.node.Node
        Node that takes the messages.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._first = self._newest = -1
        self._is_new = False
        self._fault = ""

    def note(self, stamp: int) -> None:
        """Note the stamp [ns] of a message that was accepted."""
        if self._first < 0 or stamp < self._newest:
            self._first = stamp
        self._newest, self._is_new = stamp, True

    def fault(self) -> str:
        """Return what does not go together, in one line; empty if all does.

        What is told for the first time is logged.
        """
        if self._is_new:
            before, self._fault = self._fault, self._find_fault()
            self._is_new = False
            if self._fault and not before:
                self._node.get_logger().warning(self._fault)
        return self._fault

    def _find_fault(self) -> str:
        if not self._node.get_parameter(USE_SIM_TIME).value:
            return ""
        now = self._node.get_clock().now().nanoseconds
        if now == 0:
            if self._newest - self._first < PATIENCE:
                return ""
            return (
                f"{USE_SIM_TIME} is true and nobody publishes {CLOCK.name}: set it to false where "
                "there is none"
            )
        if abs(self._newest - now) <= LARGEST_OFFSET:
            return ""
        return (
            f"{USE_SIM_TIME} is true and messages are stamped {self._newest * 1e-9:.12g} s while "
            f"{CLOCK.name} says {now * 1e-9:.12g} s: set it to false where stamps are wall time"
        )
