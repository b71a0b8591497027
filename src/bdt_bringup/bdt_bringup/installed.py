"""What is installed of the project, found by name through entry points, as ``ros2`` does it."""

from collections.abc import Sequence
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.commands import COMMAND_GROUP, NODE_GROUP, PARAMETER_GROUP, Command
from bdt_msgs_py.parameter_tables import ParameterTable
from bdt_msgs_py.topics import (
    CONTROLLER_NODE,
    DRIVER_NODE,
    PLANT_NODE,
    RECORDER_NODE,
    TWIN_NODE,
)

PACKAGE_OF_COMMAND = {
    "run": "bdt_bringup",
    "live": "bdt_live",
    "status": "bdt_bringup",
    "twins": "bdt_bringup",
    "config": "bdt_bringup",
    "record": "bdt_bags",
    "recover": "bdt_bags",
    "analyze": "bdt_analysis",
    "compare": "bdt_analysis",
    "calibrate": "bdt_study",
    "design": "bdt_study",
    "tune": "bdt_study",
    "reproduce": "bdt_study",
    "evaluate": "bdt_study",
    "sweep": "bdt_study",
    "bench": "bdt_study",
    "hardware-check": "bdt_driver",
    "drive-emulator": "bdt_drive_emulator",
}
"""The project's own subcommands in the order of the help, with the packages that bring them."""

PACKAGE_OF_NODE = {
    CONTROLLER_NODE: "bdt_controller",
    TWIN_NODE: "bdt_twin",
    RECORDER_NODE: "bdt_bags",
    PLANT_NODE: "bdt_plant",
    DRIVER_NODE: "bdt_driver",
}
"""The nodes of a loop in the order of their start; the machine, plant or driver, is last."""


def installed_commands() -> dict[str, Command]:
    """Return the subcommands that are installed: the project's in their order, then others."""
    found = _entry_points(COMMAND_GROUP)
    own = [name for name in PACKAGE_OF_COMMAND if name in found]
    names = [*own, *sorted(found.keys() - set(own))]
    return {name: found[name].load() for name in names}


def node_module(node: str) -> str:
    """Return the module of a node of the loop; it has a function ``main``.

    Raises
    ------
    BadInputError
        If the package that has the node is not installed.
    """
    return _node(NODE_GROUP, node).module


def node_class(node: str) -> Any:
    """Return the class of a node of the loop.

    Raises
    ------
    BadInputError
        If the package that has the node is not installed.
    """
    return _node(NODE_GROUP, node).load()


def parameter_table(node: str) -> ParameterTable:
    """Return the parameters of a node of the loop.

    Raises
    ------
    BadInputError
        If the package that has the node is not installed.
    """
    table: ParameterTable = _node(PARAMETER_GROUP, node).load()
    return table


def missing_packages(nodes: Sequence[str]) -> list[str]:
    """Return the packages of nodes of the loop that are not installed."""
    found = _entry_points(NODE_GROUP)
    return [PACKAGE_OF_NODE[node] for node in nodes if node not in found]


def _node(group: str, node: str) -> EntryPoint:
    found = _entry_points(group)
    if node not in found:
        raise BadInputError(f"node {node}: is in the package {PACKAGE_OF_NODE[node]}, install it")
    return found[node]


@cache
def _entry_points(group: str) -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=group)}
