"""Nodes."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from embedded_ros.endpoints import Reader, Writer
from embedded_ros.errors import RCLError, RCLInvalidROSArgsError
from embedded_ros.names import expand_valid, join
from embedded_ros.node_graph import NodeGraph
from embedded_ros.node_parameters import NodeParameters
from embedded_ros.ros_arguments import NO_ARGUMENTS, RosArguments, parse_arguments
from embedded_ros.rosout import RosoutPublisher
from embedded_ros.service_calls import ClientPorts, ServerPorts
from rclpy.callback_groups import (
    CallbackGroup,
    MutuallyExclusiveCallbackGroup,
    ReentrantCallbackGroup,
)
from rclpy.client import Client
from rclpy.clock import Clock, ROSClock
from rclpy.constants import S_TO_NS
from rclpy.context import Context
from rclpy.exceptions import NameValidationException, NotInitializedException
from rclpy.guard_condition import GuardCondition
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.logging import get_logger
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, qos_profile_parameter_events, qos_profile_services_default
from rclpy.service import Service
from rclpy.subscription import Subscription
from rclpy.time_source import TimeSource
from rclpy.timer import Rate, Timer
from rclpy.type_description_service import TypeDescriptionService
from rclpy.type_support import check_is_valid_msg_type, check_is_valid_srv_type
from rclpy.utilities import get_default_context
from rclpy.validate_namespace import validate_namespace
from rclpy.validate_node_name import validate_node_name

if TYPE_CHECKING:
    from rclpy.executors import Executor

__all__ = ["Node"]


class Node(NodeParameters, NodeGraph):
    """A participant in the ROS graph: has a name, makes publishers, timers, services and so on.

    Parameters
    ----------
    node_name : str
    context : Context, optional
        The default context by default.
    cli_args : list of str, optional
        ROS arguments for this node alone, as after ``--ros-args``.
    namespace : str, optional
    use_global_arguments : bool
        Whether the arguments of the process apply.
    enable_rosout : bool
        Whether to publish log messages on ``/rosout``.
    start_parameter_services : bool
    parameter_overrides : list of Parameter, optional
        Values that replace the defaults of parameters and those of the command line.
    allow_undeclared_parameters : bool
    automatically_declare_parameters_from_overrides : bool
    enable_logger_service : bool
        Whether others may get and set the levels of loggers.
    """

    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: list[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        start_parameter_services: bool = True,
        parameter_overrides: list[Parameter] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
        enable_logger_service: bool = False,
    ) -> None:
        from rcl_interfaces.msg import ParameterDescriptor, ParameterEvent

        self._is_destroyed = True  # until there is something to destroy
        self._context = get_default_context() if context is None else context
        session = self._context.handle
        if session is None or not session.valid:
            raise NotInitializedException("cannot create node")
        self._session = session
        self._arguments = _arguments_for_node(self._context, cli_args, use_global_arguments)
        self._name, self._namespace = self._resolve_own_name(node_name, namespace or "")
        self._init_parameters(allow_undeclared=allow_undeclared_parameters)
        self._publishers: list[Publisher] = []
        self._subscriptions: list[Subscription] = []
        self._clients: list[Client] = []
        self._services: list[Service] = []
        self._timers: list[Timer] = []
        self._guards: list[GuardCondition] = []
        self._default_callback_group = MutuallyExclusiveCallbackGroup()
        self._rate_group = ReentrantCallbackGroup()
        self._executor: weakref.ref[Executor] | None = None
        self._parameter_event_publisher = None
        self._rosout: RosoutPublisher | None = None
        logger_name = join(self._namespace, self._name).strip("/").replace("/", ".")
        self._logger = get_logger(logger_name)

        session.acquire()
        self._entities = session.graph.add_node(self._name, self._namespace)
        self._is_destroyed = False
        try:
            if enable_rosout and not self._says("--disable-rosout-logs"):
                self._rosout = RosoutPublisher(session, self._entities, logger_name)
            self._parameter_event_publisher = self.create_publisher(
                ParameterEvent, "/parameter_events", qos_profile_parameter_events
            )
            self._parameter_overrides = self._overrides(parameter_overrides or [])
            self._clock = ROSClock()
            if automatically_declare_parameters_from_overrides:
                self.declare_parameters(
                    "",
                    [
                        (name, parameter.value, ParameterDescriptor())
                        for name, parameter in self._parameter_overrides.items()
                    ],
                    ignore_override=True,
                )
            self._time_source = TimeSource(node=self)
            self._time_source.attach_clock(self._clock)
            if start_parameter_services:
                self._parameter_service = ParameterService(self)
            self._type_description_service = TypeDescriptionService(self)
            if enable_logger_service:
                from rclpy.logging_service import LoggingService

                self._logger_service = LoggingService(self)
        except BaseException:
            self.destroy_node()
            raise

    def _resolve_own_name(self, name: str, namespace: str) -> tuple[str, str]:
        namespace = namespace if namespace.startswith("/") else f"/{namespace}"
        validate_node_name(name)
        validate_namespace(namespace)
        given = name
        for arguments in self._arguments:
            new_name = arguments.node_name(given)
            if new_name is not None:
                validate_node_name(new_name)
                name = new_name
                break
        for arguments in self._arguments:
            new_namespace = arguments.namespace(given)
            if new_namespace is not None:
                validate_namespace(new_namespace)
                namespace = new_namespace
                break
        return name, namespace

    def _says(self, switch: str) -> bool:
        return any(switch in arguments.switches for arguments in self._arguments)

    def _overrides(self, given: list[Parameter]) -> dict[str, Parameter]:
        overrides: dict[str, Parameter] = {}
        for arguments in reversed(self._arguments):  # the node's own ones win
            values = arguments.parameters_of(self._name, self._namespace)
            overrides |= {name: Parameter(name, value=value) for name, value in values.items()}
        return overrides | {parameter.name: parameter for parameter in given}

    # --------------------------------------------------------------- properties

    @property
    def publishers(self) -> Iterator[Publisher]:
        """Publishers of the node."""
        return iter(list(self._publishers))

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Subscriptions of the node."""
        return iter(list(self._subscriptions))

    @property
    def clients(self) -> Iterator[Client]:
        """Service clients of the node."""
        return iter(list(self._clients))

    @property
    def services(self) -> Iterator[Service]:
        """Services of the node."""
        return iter(list(self._services))

    @property
    def timers(self) -> Iterator[Timer]:
        """Timers of the node."""
        return iter(list(self._timers))

    @property
    def guards(self) -> Iterator[GuardCondition]:
        """Guard conditions of the node."""
        return iter(list(self._guards))

    @property
    def executor(self) -> Executor | None:
        """Executor that runs the callbacks of the node, if there is one."""
        return self._executor() if self._executor is not None else None

    @executor.setter
    def executor(self, new_executor: Executor | None) -> None:
        current = self.executor
        if current is new_executor:
            return
        if current is not None:
            current.remove_node(self)
        if new_executor is None:
            self._executor = None
        else:
            new_executor.add_node(self)
            self._executor = weakref.ref(new_executor)

    def _wake_executor(self) -> None:
        executor = self.executor
        if executor is not None:
            executor.wake()

    @property
    def context(self) -> Context:
        """Context of the node."""
        return self._context

    @property
    def default_callback_group(self) -> CallbackGroup:
        """Group of the entities that are made without one."""
        return self._default_callback_group

    def get_name(self) -> str:
        """Name of the node."""
        return self._name

    def get_namespace(self) -> str:
        """Namespace of the node."""
        return self._namespace

    def get_fully_qualified_name(self) -> str:
        """Namespace and name of the node."""
        return join(self._namespace, self._name)

    def get_clock(self) -> Clock:
        """Clock of the node: simulated time if ``use_sim_time`` is set."""
        return self._clock

    def get_logger(self) -> RcutilsLogger:
        """Logger of the node."""
        return self._logger

    def _entity_types(self) -> set[str]:
        """ROS types of the publishers and subscriptions of the node."""
        types = [publisher.msg_type for publisher in self._publishers]
        types += [subscription.msg_type for subscription in self._subscriptions]
        return {msg_type._ros_type for msg_type in types}

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Expand and, unless `only_expand`, remap a topic name; ``RCLError`` if it is invalid."""
        return self._resolve_or_rcl_error(topic, only_expand, is_service=False)

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Expand and, unless `only_expand`, remap a service name; ``RCLError`` if it is invalid."""
        return self._resolve_or_rcl_error(service, only_expand, is_service=True)

    def _resolve_or_rcl_error(self, name: str, only_expand: bool, *, is_service: bool) -> str:
        try:
            return self._resolve(name, only_expand, is_service=is_service)
        except (NameValidationException, ValueError) as error:
            raise RCLError(f"failed to resolve name: {error}") from None

    def _resolve(self, name: str, only_expand: bool = False, *, is_service: bool = False) -> str:
        full_name = expand_valid(name, self._name, self._namespace, is_service=is_service)
        for arguments in () if only_expand else self._arguments:
            replacement = arguments.remap(
                full_name, self._name, self._namespace, is_service=is_service
            )
            if replacement is not None:
                return replacement
        return full_name

    # ------------------------------------------------------------------- making

    def create_publisher(
        self,
        msg_type: type[Any],
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,  # noqa: ARG002 - for QoS events
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
        publisher_class : type
        """
        profile = _profile(qos_profile)
        name = self._resolve(topic)
        check_is_valid_msg_type(msg_type)
        writer = self._session.writer(_dds_topic(name, profile), msg_type._ros_type, profile)
        publisher = publisher_class(self._session, writer, msg_type, topic, name, profile)
        self._publishers.append(publisher)
        self._session.graph.add(self._entities, writers=(writer.guid,), readers=())
        return publisher

    def create_subscription(
        self,
        msg_type: type[Any],
        topic: str,
        callback: Callable[..., Any],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,
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
        raw : bool
            Whether the callback gets CDR bytes.
        """
        profile = _profile(qos_profile)
        name = self._resolve(topic)
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
        group.add_entity(subscription)
        self._subscriptions.append(subscription)
        self._session.graph.add(self._entities, writers=(), readers=(reader.guid,))
        self._wake_executor()
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
        self._wake_executor()
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
        self._wake_executor()
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
        timer._wake = self._wake_executor
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

    def _enter(self, writer: Writer, reader: Reader) -> None:
        self._session.graph.add(self._entities, writers=(writer.guid,), readers=(reader.guid,))

    # --------------------------------------------------------------- destroying

    def destroy_publisher(self, publisher: Publisher) -> bool:
        """Destroy a publisher; False if it is not one of this node."""
        return self._destroy(self._publishers, publisher, writer=publisher._writer)

    def destroy_subscription(self, subscription: Subscription) -> bool:
        """Destroy a subscription; False if it is not one of this node."""
        return self._destroy(self._subscriptions, subscription, reader=subscription._reader)

    def destroy_client(self, client: Client) -> bool:
        """Destroy a client; False if it is not one of this node."""
        ports = client._ports
        return self._destroy(self._clients, client, ports.writer, ports.reader)

    def destroy_service(self, service: Service) -> bool:
        """Destroy a service; False if it is not one of this node."""
        ports = service._ports
        return self._destroy(self._services, service, ports.writer, ports.reader)

    def destroy_timer(self, timer: Timer) -> bool:
        """Destroy a timer; False if it is not one of this node."""
        return self._destroy(self._timers, timer)

    def destroy_guard_condition(self, guard: GuardCondition) -> bool:
        """Destroy a guard condition; False if it is not one of this node."""
        return self._destroy(self._guards, guard)

    def destroy_rate(self, rate: Rate) -> bool:
        """Destroy a rate; False if it is not one of this node."""
        success = self.destroy_timer(rate._timer)
        rate.destroy()
        return success

    def _destroy(
        self,
        entities: list[Any],
        entity: Any,
        writer: Writer | None = None,
        reader: Reader | None = None,
    ) -> bool:
        if entity not in entities:
            return False
        entities.remove(entity)
        entity.destroy()
        if (writer or reader) and not self._is_destroyed:
            self._session.graph.remove(
                self._entities,
                writers=(writer.guid,) if writer else (),
                readers=(reader.guid,) if reader else (),
            )
        self._wake_executor()
        return True

    def destroy_node(self) -> None:
        """Destroy the node and all that it made. Again is fine."""
        if self._is_destroyed:
            return
        self._is_destroyed = True
        self._parameter_event_publisher = None
        if self._rosout is not None:
            self._rosout.close()
        for entities in (
            self._publishers,
            self._subscriptions,
            self._clients,
            self._services,
            self._timers,
            self._guards,
        ):
            while entities:
                entities.pop().destroy()
        self._session.graph.remove_node(self._entities)
        self._wake_executor()
        self._session.release()

    def __del__(self) -> None:
        # A node that is dropped leaves the graph, as in rclpy.
        if not getattr(self, "_is_destroyed", True):
            self.destroy_node()


def _arguments_for_node(
    context: Context, cli_args: list[str] | None, use_global: bool
) -> tuple[RosArguments, ...]:
    """Arguments that apply to a node, its own ones first."""
    own = NO_ARGUMENTS
    if cli_args:
        try:
            own = parse_arguments(cli_args)
        except RCLInvalidROSArgsError as error:
            raise RCLInvalidROSArgsError(f"Failed to parse ROS arguments: {error}") from None
    return (own, context._arguments) if use_global else (own,)


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
