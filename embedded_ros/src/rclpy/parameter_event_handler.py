"""Reactions to changes of parameters, of any node."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from embedded_ros.names import join
from embedded_ros.parameter_reactions import (
    ParameterCallbackHandle,
    ParameterEventCallbackHandle,
    Reactions,
    parameter_in,
    parameters_in,
)
from embedded_ros.public_names import shown_in
from rclpy.qos import QoSProfile, qos_profile_parameter_events

if TYPE_CHECKING:
    from rclpy.callback_groups import CallbackGroup
    from rclpy.event_handler import SubscriptionEventCallbacks
    from rclpy.node import Node
    from rclpy.qos_overriding_options import QoSOverridingOptions

__all__ = ["ParameterCallbackHandle", "ParameterEventCallbackHandle", "ParameterEventHandler"]

shown_in(__name__, ParameterCallbackHandle, ParameterEventCallbackHandle)


class ParameterEventHandler:
    """Calls back when parameters of nodes change.

    Parameters
    ----------
    node : Node
        Subscribes to ``/parameter_events``.
    qos_profile : QoSProfile
    callback_group : CallbackGroup, optional
    event_callbacks : SubscriptionEventCallbacks, optional
    qos_overriding_options : QoSOverridingOptions, optional
    raw : bool

    Attributes
    ----------
    node : Node
    qos_profile : QoSProfile
    parameter_event_subscription : Subscription
    """

    def __init__(
        self,
        node: Node,
        qos_profile: QoSProfile = qos_profile_parameter_events,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: bool = False,
    ) -> None:
        from rcl_interfaces.msg import ParameterEvent

        self._reactions = Reactions()
        self.parameter_event_subscription = node.create_subscription(
            ParameterEvent,
            "/parameter_events",
            self._reactions.call,
            qos_profile,
            callback_group=callback_group,
            event_callbacks=event_callbacks,
            qos_overriding_options=qos_overriding_options,
            raw=raw,
        )
        self.node, self.qos_profile = node, qos_profile

    def destroy(self) -> None:
        """Stop calling back."""
        self.node.destroy_subscription(self.parameter_event_subscription)

    @staticmethod
    def get_parameter_from_event(event: Any, parameter_name: str, node_name: str) -> Any:
        """New or changed parameter of a node in an event; None if it is not there."""
        return parameter_in(event, parameter_name, node_name)

    @staticmethod
    def get_parameters_from_event(event: Any) -> Iterator[Any]:
        """New and changed parameters in an event."""
        return parameters_in(event)

    def add_parameter_callback(
        self, parameter_name: str, node_name: str, callback: Callable[[Any], Any]
    ) -> ParameterCallbackHandle:
        """Have a function called when a parameter is declared or changed.

        Parameters
        ----------
        parameter_name : str
        node_name : str
            Relative to the namespace of this handler's node; empty: this node.
        callback : callable
            Takes an ``rcl_interfaces.msg.Parameter``. The newest callback is called first.
        """
        own_name = self.node.get_fully_qualified_name()
        if node_name and not node_name.startswith("/"):
            node_name = join(self.node.get_namespace(), node_name)
        handle = ParameterCallbackHandle(parameter_name, node_name or own_name, callback)
        self._reactions.add(handle)
        return handle

    def remove_parameter_callback(self, handle: ParameterCallbackHandle) -> None:
        """Undo :meth:`add_parameter_callback`; ``RuntimeError`` if that has happened."""
        self._reactions.remove(handle)

    def add_parameter_event_callback(
        self, callback: Callable[[Any], Any]
    ) -> ParameterEventCallbackHandle:
        """Have a function called with every ``rcl_interfaces.msg.ParameterEvent``."""
        self._reactions.add(handle := ParameterEventCallbackHandle(callback))
        return handle

    def remove_parameter_event_callback(self, handle: ParameterEventCallbackHandle) -> None:
        """Undo :meth:`add_parameter_event_callback`; ``RuntimeError`` if that has happened."""
        self._reactions.remove(handle)
