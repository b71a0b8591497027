"""The service that describes the types of a node's topics."""

from __future__ import annotations

import weakref
from collections.abc import Set as AbstractSet
from typing import Any, Final, Protocol

from embedded_ros.message_classes import message_class
from embedded_ros.parameter_value import Parameter
from embedded_ros.serving import ServingNode
from embedded_ros.type_descriptions import describe

__all__ = ["START_TYPE_DESCRIPTION_SERVICE_PARAM", "TypeDescriptionService"]

START_TYPE_DESCRIPTION_SERVICE_PARAM: Final = "start_type_description_service"


class _Node(ServingNode, Protocol):
    def _entity_types(self) -> AbstractSet[str]: ...

    def has_parameter(self, name: str) -> bool: ...

    def get_parameter(self, name: str) -> Parameter: ...

    def declare_parameter(
        self, name: str, value: Any = None, descriptor: Any = None
    ) -> Parameter: ...


class TypeDescriptionService:
    """``~/get_type_description``, unless a parameter of the node says no.

    Attributes
    ----------
    service_name : str
    enabled : bool
    """

    def __init__(self, node: _Node) -> None:
        self.service_name = f"{node.get_name()}/get_type_description"
        self.enabled: bool = _wish(node).value
        if self.enabled:
            from type_description_interfaces.srv import GetTypeDescription

            # Weakly: a node that is dropped takes its services along.
            types_of_node = weakref.WeakMethod(node._entity_types)

            def answer(request: Any, response: Any) -> Any:
                in_use = types_of_node()
                return _answer(set() if in_use is None else in_use(), request, response)

            node.create_service(GetTypeDescription, self.service_name, answer)


def _wish(node: _Node) -> Parameter:
    if node.has_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM):
        return node.get_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM)
    descriptor = message_class("rcl_interfaces/msg/ParameterDescriptor")(
        description="If enabled, start the ~/get_type_description service.", read_only=True
    )
    return node.declare_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM, True, descriptor)


def _answer(in_use: AbstractSet[str], request: Any, response: Any) -> Any:
    reason = ""
    if request.type_name not in in_use:
        reason = "Type not currently in use by this node"
    else:
        description, digest = describe(request.type_name)
        if request.type_hash in ("", digest):
            response.type_description = description
        else:
            reason = "Type hash does not match"
    response.successful, response.failure_reason = not reason, reason
    return response
