"""Reactions to changes of parameters, of any node."""

from __future__ import annotations

import threading
from collections import defaultdict
from collections.abc import Callable, Iterator
from itertools import chain
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_parameter_events
from rclpy.qos_overriding_options import QoSOverridingOptions

__all__ = ["ParameterCallbackHandle", "ParameterEventCallbackHandle", "ParameterEventHandler"]


class ParameterCallbackHandle:
    """A registered callback for a parameter of a node."""

    def __init__(self, parameter_name: str, node_name: str, callback: Callable[[Any], Any]) -> None:
        self.parameter_name = parameter_name
        self.node_name = node_name
        self.callback = callback


class ParameterEventCallbackHandle:
    """A registered callback for events."""

    def __init__(self, callback: Callable[[Any], Any]) -> None:
        self.callback = callback


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

        self.node = node
        self.qos_profile = qos_profile
        # Held while callbacks run, as in rclpy: one that adds or removes callbacks waits for ever.
        self._lock = threading.Lock()
        self._parameter_callbacks: defaultdict[tuple[str, str], list[ParameterCallbackHandle]] = (
            defaultdict(list)
        )
        self._event_callbacks: list[ParameterEventCallbackHandle] = []
        self.parameter_event_subscription = node.create_subscription(
            ParameterEvent,
            "/parameter_events",
            self._on_event,
            qos_profile,
            callback_group=callback_group,
            event_callbacks=event_callbacks,
            qos_overriding_options=qos_overriding_options,
            raw=raw,
        )

    def destroy(self) -> None:
        """Stop calling back."""
        self.node.destroy_subscription(self.parameter_event_subscription)

    def _on_event(self, event: Any) -> None:
        with self._lock:
            for (name, node_name), handles in self._parameter_callbacks.items():
                parameter = self.get_parameter_from_event(event, name, node_name)
                if parameter is not None:
                    for handle in handles:
                        handle.callback(parameter)
            for event_handle in self._event_callbacks:
                event_handle.callback(event)

    @staticmethod
    def get_parameter_from_event(event: Any, parameter_name: str, node_name: str) -> Any:
        """New or changed parameter of a node in an event; None if it is not there."""
        if event.node == node_name:
            for parameter in ParameterEventHandler.get_parameters_from_event(event):
                if parameter.name == parameter_name:
                    return parameter
        return None

    @staticmethod
    def get_parameters_from_event(event: Any) -> Iterator[Any]:
        """New and changed parameters in an event."""
        yield from chain(event.new_parameters, event.changed_parameters)

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
        handle = ParameterCallbackHandle(parameter_name, self._resolve(node_name), callback)
        with self._lock:
            self._parameter_callbacks[parameter_name, handle.node_name].insert(0, handle)
        return handle

    def remove_parameter_callback(self, handle: ParameterCallbackHandle) -> None:
        """Undo :meth:`add_parameter_callback`; ``RuntimeError`` if that has happened."""
        key = handle.parameter_name, handle.node_name
        with self._lock:
            if handle not in self._parameter_callbacks.get(key, ()):
                raise RuntimeError("Callback doesn't exist")
            self._parameter_callbacks[key].remove(handle)
            if not self._parameter_callbacks[key]:
                del self._parameter_callbacks[key]

    def add_parameter_event_callback(
        self, callback: Callable[[Any], Any]
    ) -> ParameterEventCallbackHandle:
        """Have a function called with every ``rcl_interfaces.msg.ParameterEvent``."""
        handle = ParameterEventCallbackHandle(callback)
        with self._lock:
            self._event_callbacks.insert(0, handle)
        return handle

    def remove_parameter_event_callback(self, handle: ParameterEventCallbackHandle) -> None:
        """Undo :meth:`add_parameter_event_callback`; ``RuntimeError`` if that has happened."""
        with self._lock:
            if handle not in self._event_callbacks:
                raise RuntimeError("Callback doesn't exist")
            self._event_callbacks.remove(handle)

    def _resolve(self, node_name: str) -> str:
        if not node_name:
            return self.node.get_fully_qualified_name()
        if node_name.startswith("/"):
            return node_name
        return f"{self.node.get_namespace().rstrip('/')}/{node_name}"
