"""Service servers."""

from collections.abc import Callable, Coroutine
from types import CoroutineType
from typing import Any

from embedded_ros.endpoints import Reader, Writer
from embedded_ros.futures import TaskRunner
from embedded_ros.service_calls import RequestHeader, ServerPorts, ServiceAddress
from rclpy.callback_groups import CallbackGroup

__all__ = ["Service"]


class Service:
    """Answers requests; made by :meth:`rclpy.node.Node.create_service`.

    Used after :meth:`destroy` it raises :class:`InvalidHandle`.
    """

    def __init__(
        self,
        ports: ServerPorts,
        address: ServiceAddress,
        callback: Callable[[Any, Any], Any],
        callback_group: CallbackGroup,
    ) -> None:
        self._ports = ports
        #: What a wait set watches.
        self._wait_ref = ports.reader.condition
        self.srv_type, self.srv_name, self._full_name, self.qos_profile = address
        self.callback = callback
        self.callback_group = callback_group

    @property
    def _endpoints(self) -> tuple[Writer | Reader, ...]:
        return self._ports.writer, self._ports.reader

    def _take(
        self, _runner: TaskRunner | None = None
    ) -> tuple[Callable[..., Any], tuple[RequestHeader, Any]] | None:
        call = self._ports.take()
        return None if call is None else (self._serve, call)

    def _serve(self, header: RequestHeader, request: Any) -> Coroutine[Any, Any, None] | None:
        response = self.callback(request, self.srv_type.Response())
        if response.__class__ is CoroutineType:
            return self._serve_later(header, response)
        self.send_response(response, header)
        return None

    async def _serve_later(self, header: RequestHeader, response: Any) -> None:
        self.send_response(await response, header)

    def send_response(self, response: Any, header: RequestHeader) -> None:
        """Answer a request. The executor does it with what the callback returns."""
        if isinstance(response, self.srv_type.Response) and isinstance(header, RequestHeader):
            self._ports.usable().send(header, response)
        else:
            raise TypeError

    @property
    def service_name(self) -> str:
        """Service after expansion and remapping."""
        self._ports.usable()
        return self._full_name

    def destroy(self) -> None:
        """Delete the service. Again is fine."""
        self._ports.close()
