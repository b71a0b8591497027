"""Looks at a loop that runs, and prints its state: once, or each time that it changes."""

import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from bdt_bringup.loop_health import LoopHealth
from bdt_bringup.loop_state import SILENCE, LoopState
from bdt_bringup.participant import participant
from bdt_msgs_py.stop_signals import StopSignals

LOOK = 0.1
"""Wall time [s] between two looks."""
DISCOVERY = 0.5
"""Wall time [s] in which nodes find each other."""
LONGEST = SILENCE + 2.0 * DISCOVERY
"""Wall time [s] after which a node that has said nothing says nothing."""


class StatusNode(Node):
    """A node that hears how a loop is."""

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__("status", **node_arguments)
        self.health = LoopHealth(self)


def watch_loop(namespace: str, tell: Callable[[LoopHealth], bool]) -> None:
    """Listen to a loop and tell its state.

    Parameters
    ----------
    namespace : str
        From :func:`bdt_msgs_py.loop_namespace.full_namespace`.
    tell : callable
        Called from time to time, from when all nodes were heard or should have been on; returns
        whether to go on.

    Raises
    ------
    BadInputError
        If there can be no such node, for example for a ROS_DOMAIN_ID that is none.
    KeyboardInterrupt
        After Ctrl-C or SIGTERM.
    """
    begin, is_told = time.monotonic(), False
    with participant(StatusNode, namespace) as (node, executor), StopSignals() as signals:
        while True:
            executor.spin_once(timeout_sec=LOOK)
            signals.check()
            waited = time.monotonic() - begin
            has_heard_all = node.health.look_for_nodes() and bool(node.health.reports)
            is_ready = waited >= (DISCOVERY if has_heard_all else LONGEST)
            # Once ready, whoever comes later has its time to say something.
            is_told = is_told or is_ready
            if is_told and not tell(node.health):
                return


class ChangesOfState:
    """Tells which states are news."""

    def __init__(self) -> None:
        self._before: LoopState | None = None

    def is_news(self, state: LoopState) -> bool:
        """Tell whether a state differs from the one before in word or cause."""
        before, self._before = self._before, state
        return before is None or before[:2] != state[:2]
