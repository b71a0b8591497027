"""Service clients."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from embedded_ros.deadline import Deadline
from embedded_ros.endpoints import Reader, Writer
from embedded_ros.errors import RCLError
from embedded_ros.futures import TaskRunner
from embedded_ros.matching import wait_until_matched
from embedded_ros.service_calls import ClientPorts, ServiceAddress
from rclpy.callback_groups import CallbackGroup
from rclpy.context import Context
from rclpy.task import Future

__all__ = ["Client"]


class Client:
    """Calls a service; made by :meth:`rclpy.node.Node.create_client`.

    Used after :meth:`destroy` it raises :class:`InvalidHandle`.
    """

    def __init__(
        self,
        context: Context,
        ports: ClientPorts,
        address: ServiceAddress,
        callback_group: CallbackGroup,
    ) -> None:
        self.srv_type, self.srv_name, self._full_name, self.qos_profile = address
        self.callback_group = callback_group
        self.context = context
        self._ports = ports
        #: What a wait set watches.
        self._wait_ref = ports.reader.condition
        # Futures by the number of their request. Both locks are held for moments only: numbers must
        # go out in the order in which they are given.
        self._unanswered: dict[int, Future[Any]] = {}
        self._table = threading.Lock()
        self._wire = threading.Lock()

    @property
    def _endpoints(self) -> tuple[Writer | Reader, ...]:
        return self._ports.writer, self._ports.reader

    def _take(
        self, runner: TaskRunner | None = None
    ) -> tuple[Callable[..., Any], tuple[Any, ...]] | None:
        reply = self._ports.take()
        if reply is None:
            return None
        number, response = reply
        with self._table:
            future = self._unanswered.get(number)
        return None if future is None else (_settle, (future, response, runner))

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
        with future._waking(arrived.set):
            if not (future.done() or arrived.wait(timeout_sec)):
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
        ports = self._ports.usable()
        if not self.context.ok():
            raise RCLError("Failed to send request: client's context is invalid")
        future: Future[Any] = Future()

        def expect_answer(number: int) -> None:
            with self._table:
                self._unanswered[number] = future

        with self._wire:
            ports.send(request, expect_answer)
        future.add_done_callback(self.remove_pending_request)
        return future

    def get_pending_request(self, sequence_number: int) -> Future[Any]:
        """Future of a request; ``KeyError`` if it is not pending."""
        with self._table:
            return self._unanswered[sequence_number]

    def remove_pending_request(self, future: Future[Any]) -> None:
        """Forget a request: its response will be ignored."""
        with self._table:
            numbers = [number for number, each in self._unanswered.items() if each is future]
            for number in numbers:
                del self._unanswered[number]

    def service_is_ready(self) -> bool:
        """Tell whether there is a server; ``RCLError`` after the shutdown of the context."""
        ports = self._ports.usable()
        if self.context.ok():
            return ports.server_is_matched()
        raise RCLError("failed to check service availability: rcl node's context is invalid")

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
        ports = self._ports.usable()
        limit = Deadline(None if timeout_sec is None else max(0.0, timeout_sec))
        if self.context.handle is not None:
            wait_until_matched(self.context.handle, self._endpoints, ports.server_is_matched, limit)
        return self.service_is_ready()

    @property
    def service_name(self) -> str:
        """Service after expansion and remapping."""
        self._ports.usable()
        return self._full_name

    def destroy(self) -> None:
        """Delete the client. Again is fine."""
        self._ports.close()


def _settle(future: Future[Any], response: Any, runner: TaskRunner | None) -> None:
    future._run_followers_in(runner)
    future.set_result(response)
