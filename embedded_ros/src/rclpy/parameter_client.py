"""The parameters of other nodes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from rclpy.parameter import Parameter, parameter_dict_from_yaml_file
from rclpy.qos import QoSProfile, qos_profile_parameter_events, qos_profile_services_default

if TYPE_CHECKING:
    from rclpy.callback_groups import CallbackGroup
    from rclpy.client import Client
    from rclpy.event_handler import SubscriptionEventCallbacks
    from rclpy.node import Node
    from rclpy.qos_overriding_options import QoSOverridingOptions
    from rclpy.subscription import Subscription
    from rclpy.task import Future

__all__ = ["AsyncParameterClient"]

#: Types of the services by their names below a node, in the order in which they are waited for.
_SERVICES = {
    "list_parameters": "ListParameters",
    "set_parameters": "SetParameters",
    "get_parameters": "GetParameters",
    "get_parameter_types": "GetParameterTypes",
    "describe_parameters": "DescribeParameters",
    "set_parameters_atomically": "SetParametersAtomically",
}


class AsyncParameterClient:
    """Reads and sets the parameters of a remote node; every answer is a future.

    Each question may have a `callback`, which is called with the future when the answer is there.

    Parameters
    ----------
    node : Node
        Node that asks.
    remote_node_name : str
        Node that is asked.
    qos_profile : QoSProfile
    callback_group : CallbackGroup, optional

    Attributes
    ----------
    node : Node
    remote_node_name : str
    """

    def __init__(
        self,
        node: Node,
        remote_node_name: str,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> None:
        from rcl_interfaces import srv

        self.node = node
        self.remote_node_name = remote_node_name
        self._clients: dict[str, Client] = {
            name: node.create_client(
                getattr(srv, type_name),
                f"{remote_node_name}/{name}",
                qos_profile=qos_profile,
                callback_group=callback_group,
            )
            for name, type_name in _SERVICES.items()
        }

    def _ask(
        self, service: str, callback: Callable[[Future[Any]], Any] | None, **fields: Any
    ) -> Future[Any]:
        client = self._clients[service]
        answer = client.call_async(client.srv_type.Request(**fields))
        if callback is not None:
            answer.add_done_callback(callback)
        return answer

    def services_are_ready(self) -> bool:
        """Tell whether the remote node serves all its parameter services."""
        return all(client.service_is_ready() for client in self._clients.values())

    def wait_for_services(self, timeout_sec: float | None = None) -> bool:
        """Wait for the services, for ever by default; tell whether they are there."""
        if timeout_sec is None:
            return all(client.wait_for_service() for client in self._clients.values())
        end = time.monotonic() + timeout_sec
        return all(
            client.wait_for_service(max(0.0, end - time.monotonic()))
            for client in self._clients.values()
        )

    def list_parameters(
        self,
        prefixes: list[str] | None = None,
        depth: int | None = None,
        callback: Callable[[Future[Any]], Any] | None = None,
    ) -> Future[Any]:
        """Ask for names; the future gives a ``ListParameters.Response``."""
        return self._ask("list_parameters", callback, prefixes=prefixes or [], depth=depth or 0)

    def get_parameters(
        self, names: list[str], callback: Callable[[Future[Any]], Any] | None = None
    ) -> Future[Any]:
        """Ask for values; the future gives a ``GetParameters.Response``."""
        return self._ask("get_parameters", callback, names=names)

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
        """
        return self._ask("set_parameters", callback, parameters=_messages(parameters))

    def set_parameters_atomically(
        self,
        parameters: Sequence[Any],
        callback: Callable[[Future[Any]], Any] | None = None,
    ) -> Future[Any]:
        """Set all or none; the future gives a ``SetParametersAtomically.Response``."""
        return self._ask("set_parameters_atomically", callback, parameters=_messages(parameters))

    def describe_parameters(
        self, names: list[str], callback: Callable[[Future[Any]], Any] | None = None
    ) -> Future[Any]:
        """Ask for descriptors; the future gives a ``DescribeParameters.Response``."""
        return self._ask("describe_parameters", callback, names=names)

    def get_parameter_types(
        self, names: list[str], callback: Callable[[Future[Any]], Any] | None = None
    ) -> Future[Any]:
        """Ask for types; the future gives a ``GetParameterTypes.Response``."""
        return self._ask("get_parameter_types", callback, names=names)

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
        content = parameter_dict_from_yaml_file(parameter_file, use_wildcard)
        return self.set_parameters(list(content.values()), callback)

    def load_parameter_file_atomically(
        self,
        parameter_file: str,
        use_wildcard: bool = False,
        callback: Callable[[Future[Any]], Any] | None = None,
    ) -> Future[Any]:
        """Set what a parameter file holds, all or none."""
        content = parameter_dict_from_yaml_file(parameter_file, use_wildcard)
        return self.set_parameters_atomically(list(content.values()), callback)

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


def _messages(parameters: Sequence[Any]) -> list[Any]:
    return [
        parameter.to_parameter_msg() if isinstance(parameter, Parameter) else parameter
        for parameter in parameters
    ]
