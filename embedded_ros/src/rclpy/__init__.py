"""The ROS 2 client library for Python, embedded: rclpy's API on Cyclone DDS from PyPI.

A program calls :func:`init`, makes nodes (:func:`create_node` or a subclass of
:class:`rclpy.node.Node`), lets an executor run their callbacks (:func:`spin`) and ends with
:func:`shutdown`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rclpy.context import Context
from rclpy.signals import (
    SignalHandlerOptions,
    install_signal_handlers,
    uninstall_signal_handlers,
)
from rclpy.utilities import (
    get_default_context,
    get_rmw_implementation_identifier,
    ok,
    try_shutdown,
)
from rclpy.utilities import shutdown as _shutdown

if TYPE_CHECKING:
    from rclpy.executors import Executor
    from rclpy.node import Node
    from rclpy.parameter import Parameter
    from rclpy.task import Future

__all__ = [
    "create_node",
    "get_default_context",
    "get_global_executor",
    "get_rmw_implementation_identifier",
    "init",
    "ok",
    "shutdown",
    "spin",
    "spin_once",
    "spin_until_future_complete",
    "try_shutdown",
]


# Here without being imported by the program, as in rclpy, where it costs no time to load them.
_FOUND_IN = {"Future": "rclpy.task", "Parameter": "rclpy.parameter"}
_MODULES = ("guard_condition", "impl", "parameter", "task")


def __getattr__(name: str) -> Any:
    if name in _FOUND_IN:
        return getattr(import_module(_FOUND_IN[name]), name)
    if name in _MODULES:
        return import_module(f"rclpy.{name}")
    raise AttributeError(f"module 'rclpy' has no attribute {name!r}")


def init(
    *,
    args: list[str] | None = None,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
) -> None:
    """Initialize a context.

    Parameters
    ----------
    args : list of str, optional
        Command line; ``sys.argv`` by default.
    context : Context, optional
        The default context by default.
    domain_id : int, optional
        ``ROS_DOMAIN_ID`` by default.
    signal_handler_options : SignalHandlerOptions, optional
        By default SIGINT and SIGTERM are handled for the default context, and nothing for others.
    """
    context = get_default_context() if context is None else context
    if signal_handler_options is None:
        is_default = context is get_default_context()
        signal_handler_options = SignalHandlerOptions.ALL if is_default else SignalHandlerOptions.NO
    context.init(args, domain_id=domain_id)
    install_signal_handlers(signal_handler_options)


_global_executor: Executor | None = None


def get_global_executor() -> Executor:
    """Return the executor of the module's spin functions."""
    global _global_executor
    executor = _global_executor
    if executor is None:
        from rclpy.executors import SingleThreadedExecutor

        executor = _global_executor = SingleThreadedExecutor()

        def reset() -> None:
            global _global_executor
            if _global_executor is not None:
                _global_executor.shutdown()
            _global_executor = None

        # A signal may have shut the context down by now: then this resets at once.
        get_default_context().on_shutdown(reset)
    return executor


def shutdown(*, context: Context | None = None, uninstall_handlers: bool | None = None) -> None:
    """Shut a context down.

    Parameters
    ----------
    context : Context, optional
        The default context by default.
    uninstall_handlers : bool, optional
        Whether to uninstall the signal handlers. By default only with the default context.
    """
    is_default = context is None or context is get_default_context()
    _shutdown(context=context)
    if uninstall_handlers or (uninstall_handlers is None and is_default):
        uninstall_signal_handlers()


def create_node(
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
) -> Node:
    """Create a node. The arguments are those of :class:`rclpy.node.Node`."""
    from rclpy.node import Node

    return Node(
        node_name,
        context=context,
        cli_args=cli_args,
        namespace=namespace,
        use_global_arguments=use_global_arguments,
        enable_rosout=enable_rosout,
        start_parameter_services=start_parameter_services,
        parameter_overrides=parameter_overrides,
        allow_undeclared_parameters=allow_undeclared_parameters,
        automatically_declare_parameters_from_overrides=(
            automatically_declare_parameters_from_overrides
        ),
        enable_logger_service=enable_logger_service,
    )


def spin_once(
    node: Node, *, executor: Executor | None = None, timeout_sec: float | None = None
) -> None:
    """Run one callback, or return after a timeout.

    Parameters
    ----------
    node : Node
        Added to the executor for this call.
    executor : Executor, optional
        The global one by default.
    timeout_sec : float, optional
        None or negative: for ever; 0: do not wait.
    """
    executor = get_global_executor() if executor is None else executor
    try:
        executor.add_node(node)
        executor.spin_once(timeout_sec=timeout_sec)
    finally:
        executor.remove_node(node)


def spin(node: Node, executor: Executor | None = None) -> None:
    """Run callbacks until the context is shut down.

    Raises
    ------
    ExternalShutdownException
        If the context is shut down by a signal or another thread while this waits.
    """
    executor = get_global_executor() if executor is None else executor
    try:
        executor.add_node(node)
        while executor.context.ok():
            executor.spin_once()
    finally:
        executor.remove_node(node)


def spin_until_future_complete(
    node: Node,
    future: Future[Any],
    executor: Executor | None = None,
    timeout_sec: float | None = None,
) -> None:
    """Run callbacks until a future is done, the context is shut down or a timeout is over."""
    executor = get_global_executor() if executor is None else executor
    node_added = False
    try:
        node_added = executor.add_node(node)
        executor.spin_until_future_complete(future, timeout_sec)
    finally:
        if node_added:
            executor.remove_node(node)
