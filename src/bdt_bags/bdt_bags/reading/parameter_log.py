"""Parameters that a bag tells, from parameter events and diagnostics: dead zone, pitch, twin's."""

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_bags.bag_error import BagError
from bdt_msgs_py.reading import nanoseconds_from_stamp
from bdt_msgs_py.topics import DEAD_ZONE_PARAMETER

PITCH_PARAMETER = "lead_screw.pitch"
DIAGNOSED_DEAD_ZONE = f"{DEAD_ZONE_PARAMETER}_m"
_DOUBLE = 3
"""``rcl_interfaces/msg/ParameterType.PARAMETER_DOUBLE``."""
_VALUE_FIELDS = {
    1: "bool_value",
    2: "integer_value",
    _DOUBLE: "double_value",
    4: "string_value",
}
"""Field of ``rcl_interfaces/msg/ParameterValue`` for each type that is no array."""


class DeadZoneChange(NamedTuple):
    """One value of the dead zone.

    Attributes
    ----------
    stamp, received : int
        Stamp of the event and its receive time [ns].
    value : float
        Dead-zone tolerance from then on [m].
    initial : bool
        True for the value with which the parameter was declared.
    """

    stamp: int
    received: int
    value: float
    initial: bool


def parameter_changes(
    path: Path, events: Sequence[Any], received: Sequence[int], namespace: str
) -> list[DeadZoneChange]:
    """Return all values that the dead zone had, in the order of the bag.

    Parameters
    ----------
    path : Path
        The bag, for messages.
    events : sequence of ParameterEvent
        All events of the bag.
    received : sequence of int
        Their receive times [ns].
    namespace : str
        Namespace of the loop; it decides when several nodes have a dead zone.

    Raises
    ------
    BagError
        If it is unclear which node is the controller.
    """
    by_node: dict[str, list[DeadZoneChange]] = {}
    for event, arrival in zip(events, received, strict=True):
        stamp = nanoseconds_from_stamp(event.stamp)
        for parameters, initial in (
            (event.new_parameters, True),
            (event.changed_parameters, False),
        ):
            by_node.setdefault(event.node, []).extend(
                DeadZoneChange(stamp, arrival, value, initial)
                for value in _doubles(parameters, DEAD_ZONE_PARAMETER)
            )
    node = _node_of_loop(path, [node for node, changes in by_node.items() if changes], namespace)
    return by_node.get(node, [])


def recorded_pitch(events: Sequence[Any], namespace: str) -> float | None:
    """Return the pitch [m/rad] that the nodes of the loop declared, or None if the bag lacks it.

    Parameters
    ----------
    events : sequence of ParameterEvent
        All events of the bag.
    namespace : str
        Namespace of the loop.
    """
    for event in events:
        if event.node.rpartition("/")[0] == namespace:
            for value in _doubles(event.new_parameters, PITCH_PARAMETER):
                if value > 0:
                    return value
    return None


def recorded_parameters(events: Sequence[Any], node: str) -> dict[str, bool | int | float | str]:
    """Return the parameters of a node, with the values that they had last; arrays are left out.

    Parameters
    ----------
    events : sequence of ParameterEvent
        All events of the bag.
    node : str
        Name of the node with its namespace.
    """
    return {
        parameter.name: getattr(parameter.value, _VALUE_FIELDS[parameter.value.type])
        for event in events
        if event.node == node
        for parameter in (*event.new_parameters, *event.changed_parameters)
        if parameter.value.type in _VALUE_FIELDS
    }


def value_changes(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the rows of (time, value) whose value differs from that of the row before."""
    if not len(rows):
        return rows
    kept: NDArray[np.float64] = rows[np.concatenate([[True], np.diff(rows[:, 1]) != 0])]
    return kept


def diagnosed_dead_zones(
    messages: Sequence[Any], received: Sequence[int], namespace: str
) -> list[tuple[int, float]]:
    """Return ``(receive time [ns], dead zone [m])`` as the controller's diagnostics tell it.

    Parameters
    ----------
    messages : sequence of DiagnosticArray
        All diagnostics of the bag.
    received : sequence of int
        Their receive times [ns].
    namespace : str
        Namespace of the loop.
    """
    found = []
    for message, arrival in zip(messages, received, strict=True):
        for status in message.status:
            if status.name.rpartition("/")[0] != namespace:
                continue
            for item in status.values:
                if item.key == DIAGNOSED_DEAD_ZONE:
                    value = _number(item.value)
                    if value is not None:
                        found.append((arrival, value))
    return found


def _doubles(parameters: Iterable[Any], name: str) -> list[float]:
    return [
        float(parameter.value.double_value)
        for parameter in parameters
        if parameter.name == name
        and parameter.value.type == _DOUBLE
        and 0.0 <= parameter.value.double_value < math.inf
    ]


def _node_of_loop(path: Path, nodes: list[str], namespace: str) -> str:
    near = [node for node in nodes if node.rpartition("/")[0] == namespace] or nodes
    if len(near) > 1:
        raise BagError(
            f"bag {path}: nodes {' and '.join(sorted(near))} both have {DEAD_ZONE_PARAMETER}: "
            "must hold one loop"
        )
    return near[0] if near else ""


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if 0.0 <= value < math.inf else None
