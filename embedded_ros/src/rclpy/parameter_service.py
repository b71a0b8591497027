"""The services through which others read and set the parameters of a node."""

from __future__ import annotations

import weakref
from typing import TYPE_CHECKING, Any

from rclpy.exceptions import ParameterNotDeclaredException, ParameterUninitializedException
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_parameters

if TYPE_CHECKING:
    from rclpy.node import Node

__all__ = ["ParameterService"]


class ParameterService:
    """The six standard services of a node."""

    def __init__(self, node: Node) -> None:
        from rcl_interfaces import srv

        self._node = weakref.ref(node)
        for service, callback in (
            (srv.DescribeParameters, self._describe_parameters_callback),
            (srv.GetParameters, self._get_parameters_callback),
            (srv.GetParameterTypes, self._get_parameter_types_callback),
            (srv.ListParameters, self._list_parameters_callback),
            (srv.SetParameters, self._set_parameters_callback),
            (srv.SetParametersAtomically, self._set_parameters_atomically_callback),
        ):
            snake = "".join(f"_{c.lower()}" if c.isupper() else c for c in service.__name__)
            node.create_service(
                service,
                f"{node.get_name()}/{snake.lstrip('_')}",
                callback,
                qos_profile=qos_profile_parameters,
            )

    def _describe_parameters_callback(self, request: Any, response: Any) -> Any:
        node = self._get_node()
        try:
            response.descriptors = node.describe_parameters(list(request.names))
        except ParameterNotDeclaredException:
            response.descriptors = []
        return response

    def _get_parameters_callback(self, request: Any, response: Any) -> Any:
        node = self._get_node()
        try:
            response.values = [
                node.get_parameter(name).get_parameter_value() for name in request.names
            ]
        except (ParameterNotDeclaredException, ParameterUninitializedException):
            response.values = []
        return response

    def _get_parameter_types_callback(self, request: Any, response: Any) -> Any:
        node = self._get_node()
        try:
            types = node.get_parameter_types(list(request.names))
            response.types = [getattr(type_, "value", type_) for type_ in types]
        except ParameterNotDeclaredException:
            response.types = []
        return response

    def _list_parameters_callback(self, request: Any, response: Any) -> Any:
        response.result = self._get_node().list_parameters(list(request.prefixes), request.depth)
        return response

    def _set_parameters_callback(self, request: Any, response: Any) -> Any:
        node = self._get_node()
        for message in request.parameters:
            response.results.append(self._set(node, [message]))
        return response

    def _set_parameters_atomically_callback(self, request: Any, response: Any) -> Any:
        response.result = self._set(self._get_node(), request.parameters)
        return response

    @staticmethod
    def _set(node: Node, messages: list[Any]) -> Any:
        from rcl_interfaces.msg import SetParametersResult

        parameters = [Parameter.from_parameter_msg(message) for message in messages]
        try:
            return node.set_parameters_atomically(parameters)
        except ParameterNotDeclaredException as error:
            return SetParametersResult(successful=False, reason=str(error))

    def _get_node(self) -> Node:
        node = self._node()
        if node is None:
            raise ReferenceError("Expected valid node weak reference")
        return node
