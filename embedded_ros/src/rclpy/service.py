"""Service servers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from embedded_ros.service_calls import RequestHeader, ServerPorts
from rclpy.callback_groups import CallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.qos import QoSProfile

__all__ = ["Service"]


class Service:
    """Answers requests; made by :meth:`rclpy.node.Node.create_service`."""

    def __init__(
        self,
        ports: ServerPorts,
        srv_type: type[Any],
        srv_name: str,
        service_name: str,
        callback: Callable[[Any, Any], Any],
        callback_group: CallbackGroup,
        qos_profile: QoSProfile,
    ) -> None:
        self._ports = ports
        self._service_name = service_name
        self.srv_type = srv_type
        self.srv_name = srv_name
        self.callback = callback
        self.callback_group = callback_group
        self.qos_profile = qos_profile

    @property
    def _wait_ref(self) -> int:
        """What a wait set watches."""
        return self._ports.reader.condition

    def _take(self) -> tuple[RequestHeader, Any] | None:
        return self._ports.take()

    def send_response(self, response: Any, header: RequestHeader) -> None:
        """Answer a request. The executor does it with what the callback returns."""
        if not isinstance(response, self.srv_type.Response) or not isinstance(
            header, RequestHeader
        ):
            raise TypeError
        if self._ports.closed:
            raise InvalidHandle
        self._ports.send(header, response)

    @property
    def service_name(self) -> str:
        """Service after expansion and remapping."""
        if self._ports.closed:
            raise InvalidHandle
        return self._service_name

    def destroy(self) -> None:
        """Delete the service. Again is fine."""
        self._ports.close()
