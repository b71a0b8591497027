"""Service clients."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from embedded_ros.errors import RCLError
from embedded_ros.matching import wait_until_matched
from embedded_ros.service_calls import ClientPorts
from rclpy.callback_groups import CallbackGroup
from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.qos import QoSProfile
from rclpy.task import Future

__all__ = ["Client"]


class Client:
    """Calls a service; made by :meth:`rclpy.node.Node.create_client`."""

    def __init__(
        self,
        context: Context,
        ports: ClientPorts,
        srv_type: type[Any],
        srv_name: str,
        service_name: str,
        qos_profile: QoSProfile,
        callback_group: CallbackGroup,
    ) -> None:
        self.context = context
        self._ports = ports
        self._service_name = service_name
        self.srv_type = srv_type
        self.srv_name = srv_name
        self.qos_profile = qos_profile
        self.callback_group = callback_group
        self._pending_requests: dict[int, Future[Any]] = {}
        self._lock = threading.Lock()
        self._sending = threading.Lock()

    @property
    def _wait_ref(self) -> int:
        """What a wait set watches."""
        return self._ports.reader.condition

    def _take(self) -> tuple[Callable[..., Any], tuple[Any, ...]] | None:
        taken = self._ports.take()
        if taken is None:
            return None
        with self._lock:
            future = self._pending_requests.get(taken[0])
        return None if future is None else (future.set_result, (taken[1],))

    def _checked(self) -> ClientPorts:
        if self._ports.closed:
            raise InvalidHandle
        return self._ports

    def call(self, request: Any, timeout_sec: float | None = None) -> Any:
        """Call the service and block until the response is there.

        It comes only while an executor spins the node in another thread.

        Parameters
        ----------
        request : message
        timeout_sec : float, optional
            For ever by default.

        Returns
        -------
        message or None
            None after the timeout.
        """
        arrived = threading.Event()
        future = self.call_async(request)
        future.add_done_callback(lambda _: arrived.set())
        if not future.done() and not arrived.wait(timeout_sec):
            self.remove_pending_request(future)
        return future.result()

    def call_async(self, request: Any) -> Future[Any]:
        """Send a request.

        Returns
        -------
        Future
            Done when an executor takes the response. It is never done if the server dies; then
            :meth:`remove_pending_request` gives it up.
        """
        if not isinstance(request, self.srv_type.Request):
            raise TypeError
        ports = self._checked()
        if not self.context.ok():
            raise RCLError("Failed to send request: client's context is invalid")
        future: Future[Any] = Future()

        def remember(number: int) -> None:
            with self._lock:
                self._pending_requests[number] = future

        with self._sending:
            ports.send(request, remember)
        future.add_done_callback(self.remove_pending_request)
        return future

    def get_pending_request(self, sequence_number: int) -> Future[Any]:
        """Future of a request; ``KeyError`` if it is not pending."""
        with self._lock:
            return self._pending_requests[sequence_number]

    def remove_pending_request(self, future: Future[Any]) -> None:
        """Forget a request: its response will be ignored."""
        with self._lock:
            for number, pending in self._pending_requests.items():
                if pending is future:
                    del self._pending_requests[number]
                    break

    def service_is_ready(self) -> bool:
        """Tell whether there is a server; ``RCLError`` after the shutdown of the context."""
        ports = self._checked()
        if not self.context.ok():
            raise RCLError("failed to check service availability: rcl node's context is invalid")
        return ports.server_is_matched()

    def wait_for_service(self, timeout_sec: float | None = None) -> bool:
        """Wait for a server.

        Parameters
        ----------
        timeout_sec : float, optional
            For ever by default, that is until the context is shut down.

        Returns
        -------
        bool
            Whether there is one.

        Raises
        ------
        RCLError
            If the context is shut down meanwhile.
        """
        deadline = None if timeout_sec is None else time.monotonic() + timeout_sec
        ports = self._checked()
        session = self.context.handle
        if session is not None:
            wait_until_matched(
                session, [ports.writer, ports.reader], ports.server_is_matched, deadline
            )
        return self.service_is_ready()

    @property
    def service_name(self) -> str:
        """Service after expansion and remapping."""
        self._checked()
        return self._service_name

    def destroy(self) -> None:
        """Delete the client. Again is fine."""
        self._ports.close()
