"""Nodes."""

import weakref
from collections.abc import Callable

# Programs that make a node find these as rclpy.executors and so on without importing them.
import rclpy.executors
import rclpy.expand_topic_name
import rclpy.topic_endpoint_info
import rclpy.validate_full_topic_name
import rclpy.validate_topic_name  # noqa: F401
from embedded_ros.embedded_node import EmbeddedNode
from embedded_ros.node_graph import NodeGraph
from embedded_ros.node_names import NodeNames, arguments_of_node
from embedded_ros.parameter_messages import event_message
from embedded_ros.parameter_store import ParameterStore
from embedded_ros.parameter_table import Changes
from embedded_ros.public_names import also_here
from embedded_ros.ros_arguments import parameter_overrides
from embedded_ros.rosout import RosoutPublisher
from rclpy._node_entities import NodeEntities
from rclpy.clock import Clock, ROSClock
from rclpy.context import Context
from rclpy.exceptions import NotInitializedException
from rclpy.executors import Executor
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.logging import get_logger
from rclpy.logging_service import LoggingService
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService
from rclpy.qos import qos_profile_parameter_events
from rclpy.time_source import TimeSource
from rclpy.type_description_service import TypeDescriptionService
from rclpy.utilities import get_default_context

__all__ = ["Node"]

__getattr__ = also_here(
    __name__,
    {
        "rcl_interfaces.msg": (
            "FloatingPointRange IntegerRange ListParametersResult ParameterDescriptor"
            " ParameterEvent ParameterMsg=Parameter ParameterType ParameterValue"
            " SetParametersResult"
        ),
        "rcl_interfaces.srv": "ListParameters",
        "rclpy.callback_groups": (
            "CallbackGroup MutuallyExclusiveCallbackGroup ReentrantCallbackGroup"
        ),
        "rclpy.client": "Client",
        "rclpy.constants": "S_TO_NS",
        "rclpy.event_handler": "PublisherEventCallbacks SubscriptionEventCallbacks",
        "rclpy.exceptions": (
            "InvalidHandle InvalidParameterTypeException InvalidParameterValueException"
            " InvalidTopicNameException ParameterAlreadyDeclaredException"
            " ParameterImmutableException ParameterNotDeclaredException"
            " ParameterUninitializedException"
        ),
        "rclpy._rclpy_pybind11": "NodeNameNonExistentError",
        "rclpy.expand_topic_name": "expand_topic_name",
        "rclpy.guard_condition": "GuardCondition",
        "rclpy.parameter": "PARAMETER_SEPARATOR_STRING",
        "rclpy.publisher": "Publisher",
        "rclpy.qos": "QoSProfile qos_profile_services_default",
        "rclpy.qos_overriding_options": "QoSOverridingOptions",
        "rclpy.service": "Service",
        "rclpy.subscription": "Subscription",
        "rclpy.timer": "Rate Timer",
        "rclpy.topic_endpoint_info": "TopicEndpointInfo",
        "rclpy.type_support": "check_is_valid_msg_type check_is_valid_srv_type",
        "rclpy.validate_full_topic_name": "validate_full_topic_name",
        "rclpy.validate_namespace": "validate_namespace",
        "rclpy.validate_node_name": "validate_node_name",
        "rclpy.validate_parameter_name": "validate_parameter_name",
        "rclpy.validate_topic_name": "validate_topic_name",
    },
)


class Node(NodeEntities, NodeGraph):
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
        super().__init__()
        self.__context = context or get_default_context()
        session = self.__context.handle
        if session is None or not session.valid:
            raise NotInitializedException("cannot create node")
        arguments = arguments_of_node(cli_args)
        if use_global_arguments:
            arguments = (*arguments, self.__context.arguments)
        names = NodeNames(node_name, namespace or "", arguments)
        self.__logger = get_logger(names.logger)
        self.__executor: weakref.ref[Executor] | None = None
        self._embedded = EmbeddedNode(session, names, _Waking(self))
        # A node that is dropped leaves the graph, as in rclpy.
        self.__leave = self._embedded.leave_with(self)
        try:
            if enable_rosout and not names.says("--disable-rosout-logs"):
                presence = self._embedded.presence
                presence.own(RosoutPublisher(session, presence.entry, names.logger))
            self.__clock = ROSClock()
            self._parameter_store = ParameterStore(
                overrides=_overrides(names, parameter_overrides or []),
                allow_undeclared=allow_undeclared_parameters,
                announce=self.__announcer(),
            )
            if automatically_declare_parameters_from_overrides:
                given = self._parameter_store.overrides.items()
                self.declare_parameters("", [(name, override.value) for name, override in given])
            self.__time_source = TimeSource(node=self)
            self.__time_source.attach_clock(self.__clock)
            if start_parameter_services:
                self.__of_parameters = ParameterService(self)
            self.__of_types = TypeDescriptionService(self)
            if enable_logger_service:
                self.__of_loggers = LoggingService(self)
        except BaseException:
            self.destroy_node()
            raise

    def __announcer(self) -> Callable[[Changes], None]:
        """Publisher of changes of parameters; it does not hold the node."""
        from rcl_interfaces.msg import ParameterEvent

        name, clock = self._embedded.names.fully_qualified, self.__clock
        publisher = self.create_publisher(
            ParameterEvent, "/parameter_events", qos_profile_parameter_events
        )

        def announce(changes: Changes) -> None:
            publisher.publish(event_message(name, clock.now().to_msg(), changes))

        return announce

    # ------------------------------------------------------------------ what it is

    def get_name(self) -> str:
        """Name of the node."""
        return self._embedded.names.name

    def get_namespace(self) -> str:
        """Namespace of the node."""
        return self._embedded.names.namespace

    def get_fully_qualified_name(self) -> str:
        """Namespace and name of the node."""
        return self._embedded.names.fully_qualified

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Expand and, unless `only_expand`, remap a topic name; ``RCLError`` if it is invalid."""
        return self._embedded.names.resolve(topic, is_service=False, only_expand=only_expand)

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Expand and, unless `only_expand`, remap a service name; ``RCLError`` if it is invalid."""
        return self._embedded.names.resolve(service, is_service=True, only_expand=only_expand)

    @property
    def context(self) -> Context:
        """Context of the node."""
        return self.__context

    def get_clock(self) -> Clock:
        """Clock of the node: simulated time if ``use_sim_time`` is set."""
        return self.__clock

    def get_logger(self) -> RcutilsLogger:
        """Logger of the node."""
        return self.__logger

    # ------------------------------------------------------------------ who serves it

    @property
    def executor(self) -> Executor | None:
        """Executor that runs the callbacks of the node, if there is one."""
        return None if self.__executor is None else self.__executor()

    @executor.setter
    def executor(self, new_executor: Executor | None) -> None:
        former = self.executor
        if new_executor is former:
            return
        self.__executor = None if new_executor is None else weakref.ref(new_executor)
        if former is not None:
            former.remove_node(self)
        if new_executor is not None:
            new_executor.add_node(self)

    def destroy_node(self) -> None:
        """Destroy the node and all that it made. Again is fine."""
        self._embedded.destroy_all()
        self.__leave()


def _overrides(names: NodeNames, given: list[Parameter]) -> dict[str, Parameter]:
    values = parameter_overrides(names.arguments, names.name, names.namespace)
    from_arguments = {name: Parameter(name, value=value) for name, value in values.items()}
    return from_arguments | {parameter.name: parameter for parameter in given}


class _Waking:
    """Has the executor of a node look at its entities again; does not hold the node."""

    def __init__(self, node: Node) -> None:
        self._node = weakref.ref(node)

    def __call__(self) -> None:
        node = self._node()
        executor = None if node is None else node.executor
        if executor is not None:
            executor.wake()
