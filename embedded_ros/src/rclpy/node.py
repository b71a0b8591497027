"""Nodes."""

from __future__ import annotations

import weakref
from functools import partial
from typing import TYPE_CHECKING, Any

# Programs that make a node find these as rclpy.executors and so on without importing them.
import rclpy.executors
import rclpy.expand_topic_name
import rclpy.logging_service
import rclpy.validate_full_topic_name
import rclpy.validate_topic_name  # noqa: F401
from embedded_ros.entity_creation import EntityCreation
from embedded_ros.names import join
from embedded_ros.node_graph import NodeGraph
from embedded_ros.parameter_messages import event_message
from embedded_ros.parameter_store import ParameterStore
from embedded_ros.parameter_table import Changes
from embedded_ros.rosout import RosoutPublisher
from rclpy.clock import Clock, ROSClock
from rclpy.context import Context
from rclpy.exceptions import NotInitializedException
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.logging import get_logger
from rclpy.parameter import Parameter
from rclpy.parameter_service import ParameterService
from rclpy.qos import qos_profile_parameter_events
from rclpy.time_source import TimeSource
from rclpy.type_description_service import TypeDescriptionService
from rclpy.utilities import get_default_context

if TYPE_CHECKING:
    from embedded_ros.graph import NodeEntities
    from embedded_ros.session import Session
    from rclpy.executors import Executor
    from rclpy.publisher import Publisher

__all__ = ["Node"]


class Node(EntityCreation, NodeGraph):
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
        from rcl_interfaces.msg import ParameterEvent

        self._context = get_default_context() if context is None else context
        session = self._context.handle
        if session is None or not session.valid:
            raise NotInitializedException("cannot create node")
        self._session = session
        self._init_names(
            self._context,
            cli_args,
            node_name,
            namespace,
            use_global_arguments=use_global_arguments,
        )
        self._init_entities()
        self._init_groups()
        self._executor: weakref.ref[Executor] | None = None
        logger_name = join(self._namespace, self._name).strip("/").replace("/", ".")
        self._logger = get_logger(logger_name)

        session.acquire()
        self._entities = session.graph.add_node(self._name, self._namespace)
        # A node that is dropped leaves the graph, as in rclpy; this must not hold the node.
        self._leave = weakref.finalize(self, _leave, session, self._entities, self._closeables)
        self._leave.atexit = False  # threads may still use its entities
        try:
            if enable_rosout and not self._says("--disable-rosout-logs"):
                self._closeables.add(RosoutPublisher(session, self._entities, logger_name))
            self._clock = ROSClock()
            events = self.create_publisher(
                ParameterEvent, "/parameter_events", qos_profile_parameter_events
            )
            self._parameter_store = ParameterStore(
                overrides=self._overrides(parameter_overrides or []),
                allow_undeclared=allow_undeclared_parameters,
                announce=partial(_announce, self.get_fully_qualified_name(), self._clock, events),
            )
            if automatically_declare_parameters_from_overrides:
                given = self._parameter_store.overrides.items()
                self.declare_parameters("", [(name, override.value) for name, override in given])
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

    @property
    def context(self) -> Context:
        """Context of the node."""
        return self._context

    def get_clock(self) -> Clock:
        """Clock of the node: simulated time if ``use_sim_time`` is set."""
        return self._clock

    def get_logger(self) -> RcutilsLogger:
        """Logger of the node."""
        return self._logger

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

    def destroy_node(self) -> None:
        """Destroy the node and all that it made. Again is fine."""
        if not self._leave.alive:
            return
        self._destroy_entities()
        self._leave()
        self._wake_executor()


def _announce(node: str, clock: Clock, publisher: Publisher, changes: Changes) -> None:
    publisher.publish(event_message(node, clock.now().to_msg(), changes))


def _leave(session: Session, entities: NodeEntities, closeables: set[Any]) -> None:
    for closeable in closeables:
        closeable.close()
    session.graph.remove_node(entities)
    session.release()
