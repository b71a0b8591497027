"""Making entities: the part of :class:`rclpy.node.Node` with its ``create`` methods."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from embedded_ros.endpoint_events import EndpointEvents
from embedded_ros.endpoints import Reader, Writer
from embedded_ros.node_entities import OwnedEntities
from embedded_ros.node_names import NodeNames
from embedded_ros.node_parameters import NodeParameters
from embedded_ros.service_calls import ClientPorts, ServerPorts
from rclpy.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from rclpy.client import Client
from rclpy.clock import Clock
from rclpy.constants import S_TO_NS
from rclpy.context import Context
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.guard_condition import GuardCondition
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, qos_profile_services_default
from rclpy.qos_overriding_options import QoSOverridingOptions, declare_qos_parameters
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.timer import Rate, Timer
from rclpy.type_support import check_is_valid_msg_type, check_is_valid_srv_type

__all__ = ["EntityCreation"]


class EntityCreation(OwnedEntities, NodeNames, NodeParameters):
    """Makes what a node can have."""

    _context: Context
    _clock: Clock
    _logger: RcutilsLogger

    def _init_groups(self) -> None:
        self._default_callback_group = MutuallyExclusiveCallbackGroup()
        self._rate_group = ReentrantCallbackGroup()

    @property
    def default_callback_group(self) -> CallbackGroup:
        """Group of the entities that are made without one."""
        return self._default_callback_group

    def create_publisher(
        self,
        msg_type: type[Any],
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: PublisherEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        publisher_class: type[Publisher] = Publisher,
    ) -> Publisher:
        """Make a publisher.

        Parameters
        ----------
        msg_type : message class
        topic : str
        qos_profile : QoSProfile or int
            A number is the depth of a reliable, volatile profile.
        callback_group : CallbackGroup, optional
            Of the callbacks for events.
        event_callbacks : PublisherEventCallbacks, optional
        qos_overriding_options : QoSOverridingOptions, optional
            Which policies are parameters.
        publisher_class : type
        """
        profile = _profile(qos_profile)
        name = self._resolve(topic)
        if qos_overriding_options is not None:
            declare_qos_parameters("publisher", self, name, profile, qos_overriding_options)
        check_is_valid_msg_type(msg_type)
        writer = self._session.writer(_dds_topic(name, profile), msg_type._ros_type, profile)
        publisher = publisher_class(self._session, writer, msg_type, topic, name, profile)
        publisher._events = self._events(
            writer, event_callbacks or PublisherEventCallbacks(), topic, callback_group
        )
        self._publishers.append(publisher)
        self._enter(writer)
        return publisher

    def _events(
        self,
        endpoint: Writer | Reader,
        callbacks: PublisherEventCallbacks | SubscriptionEventCallbacks,
        topic: str,
        callback_group: CallbackGroup | None,
    ) -> EndpointEvents | None:
        by_status = callbacks._by_status(self._logger, topic)
        if not by_status:
            return None
        group = callback_group or self._default_callback_group
        events = EndpointEvents(endpoint, by_status, group)
        group.add_entity(events)
        return events

    def create_subscription(
        self,
        msg_type: type[Any],
        topic: str,
        callback: Callable[..., Any],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: bool = False,
    ) -> Subscription:
        """Make a subscription.

        Parameters
        ----------
        msg_type : message class
        topic : str
        callback : callable
            Takes a message, or a message and a dict with its timestamps; may be a coroutine.
        qos_profile : QoSProfile or int
            A number is the depth of a reliable, volatile profile.
        callback_group : CallbackGroup, optional
        event_callbacks : SubscriptionEventCallbacks, optional
        qos_overriding_options : QoSOverridingOptions, optional
            Which policies are parameters.
        raw : bool
            Whether the callback gets CDR bytes.
        """
        profile = _profile(qos_profile)
        name = self._resolve(topic)
        if qos_overriding_options is not None:
            declare_qos_parameters("subscription", self, name, profile, qos_overriding_options)
        check_is_valid_msg_type(msg_type)
        group = callback_group or self._default_callback_group
        reader = self._session.reader(_dds_topic(name, profile), msg_type._ros_type, profile)
        try:
            subscription = Subscription(
                reader, msg_type, topic, name, callback, group, profile, raw
            )
        except BaseException:
            reader.close()
            raise
        subscription._events = self._events(
            reader, event_callbacks or SubscriptionEventCallbacks(), topic, group
        )
        group.add_entity(subscription)
        self._subscriptions.append(subscription)
        self._enter(reader)
        return subscription

    def create_client(
        self,
        srv_type: type[Any],
        srv_name: str,
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Client:
        """Make a client of a service."""
        check_is_valid_srv_type(srv_type)
        group = callback_group or self._default_callback_group
        name = self._resolve(srv_name, is_service=True)
        ports = ClientPorts(self._session, srv_type._ros_service, name, qos_profile)
        client = Client(self._context, ports, srv_type, srv_name, name, qos_profile, group)
        group.add_entity(client)
        self._clients.append(client)
        self._enter(ports.writer, ports.reader)
        return client

    def create_service(
        self,
        srv_type: type[Any],
        srv_name: str,
        callback: Callable[[Any, Any], Any],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Service:
        """Offer a service; the callback takes request and response and returns the response."""
        check_is_valid_srv_type(srv_type)
        group = callback_group or self._default_callback_group
        name = self._resolve(srv_name, is_service=True)
        ports = ServerPorts(self._session, srv_type._ros_service, name, qos_profile)
        service = Service(ports, srv_type, srv_name, name, callback, group, qos_profile)
        group.add_entity(service)
        self._services.append(service)
        self._enter(ports.writer, ports.reader)
        return service

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[[], Any] | None,
        callback_group: CallbackGroup | None = None,
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """Make a timer.

        Parameters
        ----------
        timer_period_sec : float
        callback : callable
        callback_group : CallbackGroup, optional
        clock : Clock, optional
            The node's clock by default, which may show simulated time.
        autostart : bool
            If false the timer starts with :meth:`.Timer.reset`.
        """
        group = callback_group or self._default_callback_group
        timer = Timer(
            callback,
            group,
            int(float(timer_period_sec) * S_TO_NS),
            clock or self._clock,
            context=self._context,
            autostart=autostart,
        )
        timer._alarm.on_change = self._wake_executor
        group.add_entity(timer)
        self._timers.append(timer)
        self._wake_executor()
        return timer

    def create_guard_condition(
        self, callback: Callable[[], Any], callback_group: CallbackGroup | None = None
    ) -> GuardCondition:
        """Make a trigger for a callback."""
        group = callback_group or self._default_callback_group
        guard = GuardCondition(callback, group, context=self._context)
        group.add_entity(guard)
        self._guards.append(guard)
        self._wake_executor()
        return guard

    def create_rate(self, frequency: float, clock: Clock | None = None) -> Rate:
        """Make a rate of a frequency in hertz."""
        if frequency <= 0:
            raise ValueError("frequency must be > 0")
        timer = self.create_timer(1.0 / frequency, None, self._rate_group, clock)
        return Rate(timer, context=self._context)


def _profile(qos_profile: QoSProfile | int) -> QoSProfile:
    if isinstance(qos_profile, QoSProfile):
        return qos_profile
    if isinstance(qos_profile, int):
        if qos_profile < 0:
            raise ValueError("history depth must be greater than or equal to zero")
        return QoSProfile(depth=qos_profile)
    raise TypeError(f"Expected QoSProfile or int, but received {type(qos_profile)!r}")


def _dds_topic(name: str, profile: QoSProfile) -> str:
    return name if profile.avoid_ros_namespace_conventions else f"rt{name}"
