"""Hears the diagnostics of a loop's nodes, and says the loop's state."""

import time

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from bdt_bringup.loop_state import NODES, LoopState, NodeReport, loop_state
from bdt_msgs_py.command_errors import printable
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import DIAGNOSTICS


class LoopHealth:
    """Subscription of ``/diagnostics``, which all loops of a domain share.

    Parameters
    ----------
    node : rclpy.node.Node
        Node that listens; the loop is the one of its namespace.

    Attributes
    ----------
    reports : dict of str to NodeReport
        What nodes of the loop have said last.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._prefix = f"{node.get_namespace().rstrip('/')}/"
        self.reports: dict[str, NodeReport] = {}
        self._unheard: dict[str, NodeReport] = {}
        node.create_subscription(
            DiagnosticArray, DIAGNOSTICS.name, self._hear, qos_profile(DIAGNOSTICS)
        )

    @property
    def state(self) -> LoopState:
        """State of the loop by now."""
        return loop_state(self._unheard | self.reports, time.monotonic())

    def look_for_nodes(self) -> bool:
        """Look which nodes of the loop are there, and tell whether all of them were heard.

        One that is there and says nothing is silent from when it was seen on.
        """
        namespace, now = self._node.get_namespace(), time.monotonic()
        found = self._node.get_node_names_and_namespaces()
        there = {name for name, where in found if where == namespace and name in NODES}
        self._unheard = {
            name: self._unheard.get(name, NodeReport(0, "", "", now))
            for name in there - set(self.reports)
        }
        return not self._unheard

    def _hear(self, message: DiagnosticArray) -> None:
        for status in message.status:
            name = status.name.removeprefix(self._prefix)
            if name not in NODES or status.name != f"{self._prefix}{name}":
                continue
            said = {each.key: each.value for each in status.values}
            self.reports[name] = NodeReport(
                ord(status.level) if isinstance(status.level, bytes) else int(status.level),
                printable(status.message),
                said.get("state", ""),
                time.monotonic(),
            )
