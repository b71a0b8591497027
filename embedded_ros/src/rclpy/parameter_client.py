"""The parameters of other nodes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.client import Client
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_dict_from_yaml_file
from rclpy.qos import QoSProfile, qos_profile_parameter_events, qos_profile_services_default
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription
from rclpy.task import Future

__all__ = ["AsyncParameterClient"]


class AsyncParameterClient:
    """Reads and sets the parameters of a remote node; every answer is a future.

    Parameters
    ----------
    node : Node
        Node that asks.
    remote_node_name : str
        Node that is asked.
    qos_profile : QoSProfile
    callback_group : CallbackGroup, optional
    """

    def __init__(
        self,
        node: Node,
        remote_node_name: str,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> None:
        from rcl_interfaces import srv

        self.remote_node_name = remote_node_name
        self.node = node

        def client(service: Any, name: str) -> Client:
            return node.create_client(
                service,
                f"{remote_node_name}/{name}",
                qos_profile=qos_profile,
                callback_group=callback_group,
            )

        self._get_parameter_client = client(srv.GetParameters, "get_parameters")
        self._list_parameter_client = client(srv.ListParameters, "list_parameters")
        self._set_parameter_client = client(srv.SetParameters, "set_parameters")
        self._get_parameter_types_client = client(srv.GetParameterTypes, "get_parameter_types")
        self._describe_parameters_client = client(srv.DescribeParameters, "describe_parameters")
        self._set_parameters_atomically_client = client(
            srv.SetParametersAtomically, "set_parameters_atomically"
        )

    def _clients(self) -> list[Client]:
        return [
            self._list_parameter_client,
            self._set_parameter_client,
            self._get_parameter_client,
            self._get_parameter_types_client,
            self._describe_parameters_client,
            self._set_parameters_atomically_client,
        ]

    def services_are_ready(self) -> bool:
        """Tell whether the remote node serves all its parameter services."""
        return all(client.service_is_ready() for client in self._clients())

    def wait_for_services(self, timeout_sec: float | None = None) -> bool:
        """Wait for the services, for ever by default; tell whether they are there."""
        deadline = None if timeout_sec is None else time.monotonic() + timeout_sec
        for client in self._clients():
            left = None if deadline is None else max(0.0, deadline - time.monotonic())
            if not client.wait_for_service(left):
                return False
        return True

    def list_parameters(
        self,
        prefixes: list[str] | None = None,
        depth: int | None = None,
        callback: Callable[[Future[Any]], Any] | None = None,
    ) -> Future[Any]:
        """Ask for names; the future gives a ``ListParameters.Response``."""
        client = self._list_parameter_client
        request = client.srv_type.Request(prefixes=prefixes or [], depth=depth or 0)
        return _call(client, request, callback)

    def get_parameters(
        self, names: list[str], callback: Callable[[Future[Any]], Any] | None = None
    ) -> Future[Any]:
        """Ask for values; the future gives a ``GetParameters.Response``."""
        client = self._get_parameter_client
        return _call(client, client.srv_type.Request(names=names), callback)

    def set_parameters(
        self,
        parameters: Sequence[Any],
        callback: Callable[[Future[Any]], Any] | None = None,
    ) -> Future[Any]:
        """Set parameters one by one; the future gives a ``SetParameters.Response``.

        Parameters
        ----------
        parameters : sequence of Parameter or rcl_interfaces.msg.Parameter
        callback : callable, optional
            Called when the answer is there.
        """
        client = self._set_parameter_client
        return _call(client, client.srv_type.Request(parameters=_messages(parameters)), callback)

    def set_parameters_atomically(
        self,
        parameters: Sequence[Any],
        callback: Callable[[Future[Any]], Any] | None = None,
    ) -> Future[Any]:
        """Set all or none; the future gives a ``SetParametersAtomically.Response``."""
        client = self._set_parameters_atomically_client
        return _call(client, client.srv_type.Request(parameters=_messages(parameters)), callback)

    def describe_parameters(
        self, names: list[str], callback: Callable[[Future[Any]], Any] | None = None
    ) -> Future[Any]:
        """Ask for descriptors; the future gives a ``DescribeParameters.Response``."""
        client = self._describe_parameters_client
        return _call(client, client.srv_type.Request(names=names), callback)

    def get_parameter_types(
        self, names: list[str], callback: Callable[[Future[Any]], Any] | None = None
    ) -> Future[Any]:
        """Ask for types; the future gives a ``GetParameterTypes.Response``."""
        client = self._get_parameter_types_client
        return _call(client, client.srv_type.Request(names=names), callback)

    def delete_parameters(
        self, names: list[str], callback: Callable[[Future[Any]], Any] | None = None
    ) -> Future[Any]:
        """Unset dynamic parameters; the future gives a ``SetParameters.Response``."""
        return self.set_parameters([Parameter(name) for name in names], callback)

    def load_parameter_file(
        self,
        parameter_file: str,
        use_wildcard: bool = False,
        callback: Callable[[Future[Any]], Any] | None = None,
    ) -> Future[Any]:
        """Set what a parameter file holds, one by one."""
        parameters = parameter_dict_from_yaml_file(parameter_file, use_wildcard)
        return self.set_parameters(list(parameters.values()), callback)

    def load_parameter_file_atomically(
        self,
        parameter_file: str,
        use_wildcard: bool = False,
        callback: Callable[[Future[Any]], Any] | None = None,
    ) -> Future[Any]:
        """Set what a parameter file holds, all or none."""
        parameters = parameter_dict_from_yaml_file(parameter_file, use_wildcard)
        return self.set_parameters_atomically(list(parameters.values()), callback)

    def on_parameter_event(
        self,
        callback: Callable[..., Any],
        qos_profile: QoSProfile = qos_profile_parameter_events,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: bool = False,
    ) -> Subscription:
        """Subscribe to the parameter events of all nodes."""
        from rcl_interfaces.msg import ParameterEvent

        return self.node.create_subscription(
            ParameterEvent,
            "/parameter_events",
            callback,
            qos_profile,
            callback_group=callback_group,
            event_callbacks=event_callbacks,
            qos_overriding_options=qos_overriding_options,
            raw=raw,
        )


def _call(
    client: Client, request: Any, callback: Callable[[Future[Any]], Any] | None
) -> Future[Any]:
    future = client.call_async(request)
    if callback is not None:
        future.add_done_callback(callback)
    return future


def _messages(parameters: Sequence[Any]) -> list[Any]:
    return [
        parameter.to_parameter_msg() if isinstance(parameter, Parameter) else parameter
        for parameter in parameters
    ]
