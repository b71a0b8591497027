"""A real machine in a run: armed when all nodes are there, watched, and disarmed at the end."""

import time
from collections.abc import Sequence
from typing import Any

from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import Trigger

from bdt_bringup.loop_state import ERROR, LoopState
from bdt_bringup.monitor import MonitorNode
from bdt_msgs_py.command_errors import LoopError
from bdt_msgs_py.topics import DRIVER_NODE

ARMING_TIMEOUT = 60.0
"""Wall time [s] after which a machine that is not armed will not be."""
DISARMING_TIMEOUT = 5.0
"""Wall time [s] that the driver has to disarm; its end stops the machine in any case."""


class RealMachine:
    """The driver as `bdt run` sees it; what the progress display shows of the loop.

    Parameters
    ----------
    monitor : MonitorNode
        Node that listens to the loop, in its namespace.
    nodes : sequence of str
        Names of the nodes without which the machine is not armed.

    Attributes
    ----------
    simulated_time : float
        Time since the machine was armed [s].
    gap, dead_zone : float or None
        See :class:`bdt_bringup.monitor.MonitorNode`.
    """

    def __init__(self, monitor: MonitorNode, nodes: Sequence[str]) -> None:
        self._monitor = monitor
        self._awaited = {(name, monitor.get_namespace()) for name in nodes}
        self._arm = monitor.create_client(Trigger, f"{DRIVER_NODE}/arm")
        self._disarm = monitor.create_client(Trigger, f"{DRIVER_NODE}/disarm")
        self._began = time.monotonic()
        self._armed_at: float | None = None
        self._answer: Any = None
        self._reason = "its nodes have not started"
        self.simulated_time = 0.0
        self.gap: float | None = None
        self.dead_zone: float | None = None

    @property
    def state(self) -> LoopState:
        """How the loop is; see :class:`bdt_bringup.monitor.MonitorNode`."""
        return self._monitor.state

    def real_time_factor(self) -> float | None:
        """Return None: a real machine has no other time."""
        return None

    def look(self) -> None:
        """Arm the machine once everybody is there, and see whether it is well.

        Raises
        ------
        LoopError
            If it does not get armed, or has a fault; the text says why.
        """
        said = self._monitor.health.reports.get(DRIVER_NODE)
        if said is not None and said.level >= ERROR:
            raise LoopError(f"node {DRIVER_NODE}: the drive is stopped: {said.text}")
        self.gap, self.dead_zone = self._monitor.gap, self._monitor.dead_zone
        now = time.monotonic()
        if self._armed_at is not None:
            self.simulated_time = now - self._armed_at
            return
        if self._answer is None:
            self._call_when_ready()
        elif self._answer.done():
            answer, self._answer = self._answer.result(), None
            self._reason = answer.message
            self._armed_at = now if answer.success else None
        if self._armed_at is None and now - self._began > ARMING_TIMEOUT:
            raise LoopError(f"node {DRIVER_NODE}: is not armed: {self._reason}")

    def disarm(self, executor: SingleThreadedExecutor) -> None:
        """Disarm the machine.

        Parameters
        ----------
        executor : rclpy.executors.SingleThreadedExecutor
            Runs the monitor.
        """
        answer = self._disarm.call_async(Trigger.Request())
        executor.spin_until_future_complete(answer, timeout_sec=DISARMING_TIMEOUT)

    def _call_when_ready(self) -> None:
        here = set(self._monitor.get_node_names_and_namespaces())
        if self._awaited <= here and self._arm.service_is_ready():
            self._answer = self._arm.call_async(Trigger.Request())
