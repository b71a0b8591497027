"""The services through which others read and set the parameters of a node."""

from __future__ import annotations

from functools import partial
from typing import Protocol

from embedded_ros.parameter_services import ANSWERS
from embedded_ros.parameter_store import ParameterStore
from embedded_ros.serving import ServingNode
from rclpy.qos import qos_profile_parameters

__all__ = ["ParameterService"]


class _Node(ServingNode, Protocol):
    _parameter_store: ParameterStore


class ParameterService:
    """Serves the parameters of a node; the services hold its parameters, not the node."""

    def __init__(self, node: _Node) -> None:
        from rcl_interfaces import srv

        for name, (type_name, answer) in ANSWERS.items():
            node.create_service(
                getattr(srv, type_name),
                f"{node.get_name()}/{name}",
                partial(answer, node._parameter_store),
                qos_profile=qos_profile_parameters,
            )
