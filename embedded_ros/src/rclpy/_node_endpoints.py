"""Topics and services: the part of :class:`rclpy.node.Node` that makes what the network sees."""

from collections.abc import Callable, Iterator
from typing import Any, Literal

from embedded_ros.embedded_node import EmbeddedNode
from embedded_ros.endpoint_events import EndpointEvents
from embedded_ros.endpoints import Reader, Writer
from embedded_ros.entity_registry import Kind
from embedded_ros.node_parameters import NodeParameters
from embedded_ros.service_calls import ClientPorts, ServerPorts, ServiceAddress
from rclpy.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
)
from rclpy.client import Client
from rclpy.context import Context
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, qos_profile_services_default
from rclpy.qos_overriding_options import QoSOverridingOptions, declare_qos_parameters
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.type_support import check_is_valid_msg_type, check_is_valid_srv_type

__all__ = ["NodeEndpoints"]


class NodeEndpoints(NodeParameters):
    """Publishers, subscriptions, clients and services."""

    _embedded: EmbeddedNode

    @property
    def context(self) -> Context:
        """Context of the node."""
        raise NotImplementedError

    def get_logger(self) -> RcutilsLogger:
        """Logger of the node."""
        raise NotImplementedError

    def __init__(self) -> None:
        self.__group = MutuallyExclusiveCallbackGroup()

    @property
    def default_callback_group(self) -> CallbackGroup:
        """Group of the entities that are made without one."""
        return self.__group

    @property
    def publishers(self) -> Iterator[Publisher]:
        """Publishers of the node."""
        return self._embedded.registry.of(Kind.PUBLISHER)

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Subscriptions of the node."""
        return self._embedded.registry.of(Kind.SUBSCRIPTION)

    @property
    def clients(self) -> Iterator[Client]:
        """Service clients of the node."""
        return self._embedded.registry.of(Kind.CLIENT)

    @property
    def services(self) -> Iterator[Service]:
        """Services of the node."""
        return self._embedded.registry.of(Kind.SERVICE)

    def _entity_types(self) -> set[str]:
        """ROS types of the publishers and subscriptions of the node."""
        types = [publisher.msg_type for publisher in self.publishers]
        types += [subscription.msg_type for subscription in self.subscriptions]
        return {msg_type._ros_type for msg_type in types}

    # ------------------------------------------------------------------ topics

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
        name = self.__topic_name("publisher", topic, profile, qos_overriding_options)
        check_is_valid_msg_type(msg_type)
        writer = self._embedded.session.writer(
            _dds_topic(name, profile), msg_type._ros_type, profile
        )
        publisher = publisher_class(self._embedded.session, writer, msg_type, topic, name, profile)
        callbacks = event_callbacks or PublisherEventCallbacks()
        publisher._watched_events = self.__watch(writer, callbacks, topic, callback_group)
        self._embedded.add(Kind.PUBLISHER, publisher)
        return publisher

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
        name = self.__topic_name("subscription", topic, profile, qos_overriding_options)
        check_is_valid_msg_type(msg_type)
        group = callback_group or self.__group
        reader = self._embedded.session.reader(
            _dds_topic(name, profile), msg_type._ros_type, profile
        )
        try:
            subscription = Subscription(
                reader, msg_type, topic, name, callback, group, profile, raw
            )
        except BaseException:
            reader.close()
            raise
        callbacks = event_callbacks or SubscriptionEventCallbacks()
        subscription._watched_events = self.__watch(reader, callbacks, topic, group)
        self._embedded.add(Kind.SUBSCRIPTION, subscription, group)
        return subscription

    def __topic_name(
        self,
        kind: Literal["publisher", "subscription"],
        topic: str,
        profile: QoSProfile,
        options: QoSOverridingOptions | None,
    ) -> str:
        name = self._embedded.names.full_name(topic)
        if options is not None:
            declare_qos_parameters(kind, self, name, profile, options)
        return name

    def __watch(
        self,
        endpoint: Writer | Reader,
        callbacks: PublisherEventCallbacks | SubscriptionEventCallbacks,
        topic: str,
        callback_group: CallbackGroup | None,
    ) -> EndpointEvents | None:
        by_status = callbacks._by_status(self.get_logger(), topic)
        if not by_status:
            return None
        group = callback_group or self.__group
        events = EndpointEvents(endpoint, by_status, group)
        group.add_entity(events)
        self._embedded.registry.add(Kind.EVENTS, events)
        return events

    # ------------------------------------------------------------------ services

    def create_client(
        self,
        srv_type: type[Any],
        srv_name: str,
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> Client:
        """Make a client of a service."""
        address = self.__address(srv_type, srv_name, qos_profile)
        group = callback_group or self.__group
        ports = ClientPorts(
            self._embedded.session, srv_type._ros_service, address.full_name, address.profile
        )
        client = Client(self.context, ports, address, group)
        self._embedded.add(Kind.CLIENT, client, group)
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
        address = self.__address(srv_type, srv_name, qos_profile)
        group = callback_group or self.__group
        ports = ServerPorts(
            self._embedded.session, srv_type._ros_service, address.full_name, address.profile
        )
        service = Service(ports, address, callback, group)
        self._embedded.add(Kind.SERVICE, service, group)
        return service

    def __address(self, srv_type: type[Any], name: str, profile: QoSProfile) -> ServiceAddress:
        check_is_valid_srv_type(srv_type)
        return ServiceAddress(
            srv_type, name, self._embedded.names.full_name(name, is_service=True), profile
        )

    # ------------------------------------------------------------------ destroying

    def destroy_publisher(self, publisher: Publisher) -> bool:
        """Destroy a publisher; False if it is not one of this node."""
        return self._embedded.remove(Kind.PUBLISHER, publisher)

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """Destroy a subscription; False if it is not one of this node."""
        return self._embedded.remove(Kind.SUBSCRIPTION, subscription)

    def destroy_client(self, client: Client) -> bool:
        """Destroy a client; False if it is not one of this node."""
        return self._embedded.remove(Kind.CLIENT, client)

    def destroy_service(self, service: Service) -> bool:
        """Destroy a service; False if it is not one of this node."""
        return self._embedded.remove(Kind.SERVICE, service)


def _profile(given: QoSProfile | int) -> QoSProfile:
    match given:
        case QoSProfile():
            return given
        case int() if given >= 0:
            return QoSProfile(depth=given)
        case int():
            raise ValueError("history depth must be greater than or equal to zero")
    raise TypeError(f"Expected QoSProfile or int, but received {type(given)!r}")


def _dds_topic(name: str, profile: QoSProfile) -> str:
    return name if profile.avoid_ros_namespace_conventions else f"rt{name}"
