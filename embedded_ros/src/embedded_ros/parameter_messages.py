"""Messages about parameters: what a node answers, and what it tells the others."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from embedded_ros import parameter_selection
from embedded_ros.message_classes import message_class
from embedded_ros.parameter_rules import Objection
from embedded_ros.parameter_table import Changes

__all__ = ["event_message", "listing_message", "result_message"]


def result_message(refused: Objection | None) -> Any:
    """``rcl_interfaces.msg.SetParametersResult`` of an attempt to set parameters."""
    result = message_class("rcl_interfaces/msg/SetParametersResult")
    return result(successful=True) if refused is None else result(reason=refused.reason)


def listing_message(names: Iterable[str], prefixes: Sequence[str], depth: int) -> Any:
    """``rcl_interfaces.msg.ListParametersResult``; see :func:`.parameter_selection.select`."""
    selected = parameter_selection.select(names, prefixes, depth)
    return message_class("rcl_interfaces/msg/ListParametersResult")(
        names=selected, prefixes=parameter_selection.parents(selected)
    )


def event_message(node: str, stamp: Any, changes: Changes) -> Any:
    """``rcl_interfaces.msg.ParameterEvent`` of a change.

    Parameters
    ----------
    node : str
        Full name of the node whose parameters changed.
    stamp : builtin_interfaces.msg.Time
    changes : Changes
    """
    return message_class("rcl_interfaces/msg/ParameterEvent")(
        stamp=stamp,
        node=node,
        new_parameters=[parameter.to_parameter_msg() for parameter in changes.new],
        changed_parameters=[parameter.to_parameter_msg() for parameter in changes.changed],
        deleted_parameters=[parameter.to_parameter_msg() for parameter in changes.deleted],
    )
