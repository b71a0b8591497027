"""The service that describes the types of a node's topics."""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING, Any, Final

from embedded_ros.type_descriptions import describe

if TYPE_CHECKING:
    from rclpy.node import Node

__all__ = ["START_TYPE_DESCRIPTION_SERVICE_PARAM", "TypeDescriptionService"]

START_TYPE_DESCRIPTION_SERVICE_PARAM: Final = "start_type_description_service"


class TypeDescriptionService:
    """``~/get_type_description``, unless a parameter of the node says no."""

    def __init__(self, node: Node) -> None:
        from rcl_interfaces.msg import ParameterDescriptor
        from type_description_interfaces.srv import GetTypeDescription

        self._node = weakref.ref(node)
        self.service_name = f"{node.get_name()}/get_type_description"
        if not node.has_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM):
            descriptor = ParameterDescriptor(
                description="If enabled, start the ~/get_type_description service.",
                read_only=True,
            )
            node.declare_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM, True, descriptor)
        self.enabled: bool = node.get_parameter(START_TYPE_DESCRIPTION_SERVICE_PARAM).value
        if self.enabled:
            node.create_service(GetTypeDescription, self.service_name, self._service_callback)

    def _service_callback(self, request: Any, response: Any) -> Any:
        node = self._node()
        known = node._entity_types() if node is not None else set()
        response.successful = False
        if request.type_name not in known:
            response.failure_reason = "Type not currently in use by this node"
            return response
        description, digest = describe(request.type_name)
        if request.type_hash and request.type_hash != digest:
            response.failure_reason = "Type hash does not match"
            return response
        response.successful = True
        response.type_description = description
        return response
