"""The ROS 2 client library for Python, embedded: rclpy's API on Cyclone DDS from PyPI.

A program calls :func:`init`, makes nodes (:func:`create_node` or a subclass of
:class:`rclpy.node.Node`), lets an executor run their callbacks (:func:`spin`) and ends with
:func:`shutdown`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from embedded_ros.public_names import also_here
from rclpy import _rclpy_pybind11, exceptions  # noqa: F401 - programs find errors there
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
_NAMES = also_here(__name__, {"rclpy.parameter": "Parameter", "rclpy.task": "Future"})
_MODULES = ("guard_condition", "impl", "parameter", "task")


def __getattr__(name: str) -> Any:
    return import_module(f"rclpy.{name}") if name in _MODULES else _NAMES(name)


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
    default = get_default_context()
    chosen = context or default
    chosen.init(args, domain_id=domain_id)
    if signal_handler_options is None:
        handles_signals = chosen is default
        options = SignalHandlerOptions.ALL if handles_signals else SignalHandlerOptions.NO
        signal_handler_options = options
    install_signal_handlers(signal_handler_options)


class _GlobalExecutor:
    """The executor of the spin functions; gone with its context, made again when asked for."""

    executor: Executor | None = None

    def get(self) -> Executor:
        if self.executor is None:
            from rclpy.executors import SingleThreadedExecutor

            self.executor = SingleThreadedExecutor()
            # A signal may have shut the context down by now: then this forgets at once.
            made = self.executor
            get_default_context().on_shutdown(self.forget)
            return made
        return self.executor

    def forget(self) -> None:
        executor, self.executor = self.executor, None
        if executor is not None:
            executor.shutdown()


_global = _GlobalExecutor()


def get_global_executor() -> Executor:
    """Return the executor of the module's spin functions."""
    return _global.get()


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


class _Serving:
    """Has an executor serve a node for the time of a ``with`` block.

    No generator: programs that spin once for each message enter one each time, and it would be 1.5
    of the 25 us that they need.

    Parameters
    ----------
    node : Node
    executor : Executor or None
        None: the global one.
    even_if_there : bool
        Whether a node that the executor served before leaves it, too.
    """

    __slots__ = ("_executor", "_leaves", "_node")

    def __init__(self, node: Node, executor: Executor | None, *, even_if_there: bool) -> None:
        self._node = node
        self._executor = executor or _global.get()
        self._leaves = even_if_there

    def __enter__(self) -> Executor:
        is_new = self._executor.add_node(self._node)
        self._leaves = self._leaves or is_new
        return self._executor

    def __exit__(self, *_: object) -> None:
        if self._leaves:
            self._executor.remove_node(self._node)


def spin_once(
    node: Node, *, executor: Executor | None = None, timeout_sec: float | None = None
) -> None:
    """Run one callback, or return after a timeout.

    Parameters
    ----------
    node : Node
        Added to the executor, and removed at the end.
    executor : Executor, optional
        The global one by default.
    timeout_sec : float, optional
        None or negative: for ever; 0: do not wait.
    """
    with _Serving(node, executor, even_if_there=True) as chosen:
        chosen.spin_once(timeout_sec=timeout_sec)


def spin(node: Node, executor: Executor | None = None) -> None:
    """Run callbacks until the context is shut down. The node is removed from the executor then.

    Raises
    ------
    ExternalShutdownException
        If the context is shut down by a signal or another thread while this waits.
    """
    with _Serving(node, executor, even_if_there=True) as chosen:
        while chosen.context.ok():
            chosen.spin_once()


def spin_until_future_complete(
    node: Node,
    future: Future[Any],
    executor: Executor | None = None,
    timeout_sec: float | None = None,
) -> None:
    """Run callbacks until a future is done, the context is shut down or a timeout is over.

    A node that the executor served before stays with it.
    """
    with _Serving(node, executor, even_if_there=False) as chosen:
        chosen.spin_until_future_complete(future, timeout_sec)
