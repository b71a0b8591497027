"""Health of a node on /diagnostics, once a second of wall time."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import DIAGNOSTICS

PERIOD = 0.9871
"""Time between two messages [s]: about one.

It is no multiple of a usual control period. A timer that is one comes due at the same place of a
period each time, and where that lies between a measurement and its command, it delays each of them.
"""


class Health(NamedTuple):
    """State of a node.

    Attributes
    ----------
    ok : bool
        Whether nothing needs attention.
    summary : str
        One line.
    values : mapping
        Numbers with their names.
    is_error : bool
        Whether the machine was stopped: an error, more than a warning.
    """

    ok: bool
    summary: str
    values: Mapping[str, object]
    is_error: bool = False

    @property
    def level(self) -> bytes:
        """Level of a ``DiagnosticStatus``."""
        worst = DiagnosticStatus.ERROR if self.is_error else DiagnosticStatus.WARN
        return bytes(DiagnosticStatus.OK if self.ok else worst)


class DiagnosticsPublisher:
    """Publishes what `report` returns as one status.

    The timer runs on the steady clock: a plant that waits does not advance simulated time, and
    just then its health is of interest.

    Parameters
    ----------
    node : rclpy.node.Node
        Node whose health it is.
    report : callable
        Returns the current :class:`Health`.
    """

    def __init__(self, node: Node, report: Callable[[], Health]) -> None:
        self._node = node
        self._report = report
        self._publisher = node.create_publisher(
            DiagnosticArray, DIAGNOSTICS.name, qos_profile(DIAGNOSTICS)
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(PERIOD, self.publish, clock=steady)

    def publish(self) -> None:
        """Publish the health now."""
        health = self._report()
        status = DiagnosticStatus(
            level=health.level,
            name=self._node.get_fully_qualified_name(),
            message=health.summary,
            values=[KeyValue(key=key, value=str(value)) for key, value in health.values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(message)
