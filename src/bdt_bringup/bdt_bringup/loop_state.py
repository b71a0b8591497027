"""The state of a loop in one word with its reason, from what its nodes say of themselves."""

from collections.abc import Mapping
from typing import NamedTuple

from bdt_msgs_py.topics import (
    CONTROLLER_NODE,
    DRIVER_NODE,
    PLANT_NODE,
    RECORDER_NODE,
    TWIN_NODE,
)

OK, DEGRADED, STOPPED = "ok", "degraded", "stopped"

MACHINES = (PLANT_NODE, DRIVER_NODE)
"""Nodes that move something; a loop has one of them."""
NODES = (*MACHINES, CONTROLLER_NODE, TWIN_NODE, RECORDER_NODE)
"""Nodes of a loop, those first without which it stops."""

SILENCE = 3.0
"""Wall time [s] without a word after which a node is gone; each says something once a second."""
DRIVING = "armed"
"""State of a driver that moves its machine."""
WARNING, ERROR = 1, 2
"""Levels of a ``DiagnosticStatus`` that are not OK."""


class NodeReport(NamedTuple):
    """What a node has said last.

    Attributes
    ----------
    level : int
        Level of its ``DiagnosticStatus``: 0 OK, 1 warning, 2 error.
    text : str
        Its summary.
    state : str
        State that a driver has; empty from other nodes.
    heard : float
        Wall time at which it was heard [s], of any origin.
    """

    level: int
    text: str
    state: str
    heard: float


class LoopState(NamedTuple):
    """State of a loop.

    Attributes
    ----------
    word : str
        ``ok``, ``degraded`` (it runs, and something needs attention) or ``stopped``.
    node : str
        Node that is the cause; empty if it is nobody's.
    reason : str
        Why, in one line.
    """

    word: str
    node: str
    reason: str

    def __str__(self) -> str:
        """Return word, node and reason as a line."""
        cause = f"{self.node}: " if self.node else ""
        return f"{self.word}: {cause}{self.reason}"


def loop_state(reports: Mapping[str, NodeReport], now: float) -> LoopState:
    """Return the state of a loop.

    It is stopped when nothing is controlled: the machine or the controller is silent, the plant
    is in error, or the driver is not armed. What else is silent or not OK degrades it. Of several
    causes the node counts without which a loop can do least.

    Parameters
    ----------
    reports : mapping of str to NodeReport
        What nodes have said last, by their names of ``NODES``.
    now : float
        Wall time [s].
    """
    if not reports:
        return LoopState(STOPPED, "", "no node has said anything")
    machines = [name for name in MACHINES if name in reports]
    # What has taken the place of a machine that went away is the machine.
    machine = max(machines, key=lambda name: reports[name].heard, default="")
    stopped = _stopped(reports, machine, now)
    return stopped or _degraded(reports, machine, now) or _well(reports)


def _stopped(reports: Mapping[str, NodeReport], machine: str, now: float) -> LoopState | None:
    for name, what in ((machine, "plant or driver"), (CONTROLLER_NODE, "controller")):
        if name not in reports:
            return LoopState(STOPPED, "", f"no {what} has said anything")
        reason = _silence(reports[name], now) or _standstill(reports[name])
        if reason:
            return LoopState(STOPPED, name, reason)
    return None


def _degraded(reports: Mapping[str, NodeReport], machine: str, now: float) -> LoopState | None:
    for name in NODES:
        if name not in reports or (name in MACHINES and name != machine):
            continue
        report = reports[name]
        reason = report.text if report.level >= WARNING else _silence(report, now)
        if reason:
            return LoopState(DEGRADED, name, reason)
    return None


def _well(reports: Mapping[str, NodeReport]) -> LoopState:
    if TWIN_NODE not in reports:
        return LoopState(OK, "", "machine and controller are well, there is no twin")
    return LoopState(OK, "", f"{len(reports)} nodes are well")


def _silence(report: NodeReport, now: float) -> str:
    age = now - report.heard
    return f"has said nothing for {age:.0f} s" if age > SILENCE else ""


def _standstill(report: NodeReport) -> str:
    """Return why a machine does not move; empty if it may."""
    if report.level >= ERROR:
        return report.text
    return report.text if report.state not in ("", DRIVING) else ""
