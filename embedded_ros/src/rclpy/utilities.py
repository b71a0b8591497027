"""The default context and what the package offers for it."""

import sys
import threading
from collections.abc import Sequence

from embedded_ros.argument_encoding import check_encoding
from embedded_ros.errors import RCLInvalidROSArgsError
from embedded_ros.ros_arguments import parse_arguments, without_ros_arguments
from rclpy.constants import S_TO_NS
from rclpy.context import Context

__all__ = [
    "get_available_rmw_implementations",
    "get_default_context",
    "get_rmw_implementation_identifier",
    "ok",
    "remove_ros_args",
    "shutdown",
    "timeout_sec_to_nsec",
    "try_shutdown",
]


class _Default:
    """Holds the default context; makes one when it is asked for after the last one's end."""

    def __init__(self) -> None:
        self._context: Context | None = None
        self._lock = threading.Lock()

    def get(self) -> Context:
        with self._lock:
            if self._context is None:
                self._context = Context()
            return self._context

    def give_up(self, context: Context) -> None:
        with self._lock:
            if self._context is context:
                self._context = None


_default = _Default()


def get_default_context(*, shutting_down: bool = False) -> Context:
    """Return the default context; after `shutting_down` the next call makes a new one."""
    context = _default.get()
    if shutting_down:
        _default.give_up(context)
    return context


def remove_ros_args(args: Sequence[str] | None = None) -> list[str]:
    """Return the arguments that are not ROS's.

    Parameters
    ----------
    args : sequence of str, optional
        ``sys.argv`` by default.

    Raises
    ------
    UnicodeEncodeError
        If one is not UTF-8.
    RCLInvalidROSArgsError
        If one of ROS's is malformed.
    """
    words = sys.argv if args is None else args
    check_encoding(words)
    try:
        parse_arguments(words)
    except RCLInvalidROSArgsError as error:
        raise RCLInvalidROSArgsError(f"Failed to parse ROS arguments: {error}") from None
    return without_ros_arguments(words)


def ok(*, context: Context | None = None) -> bool:
    """Tell whether a context is initialized and not shut down."""
    return (context or _default.get()).ok()


def shutdown(*, context: Context | None = None) -> None:
    """Shut a context down; by default the default context, which is replaced."""
    (context or get_default_context(shutting_down=True)).shutdown()


def try_shutdown(*, context: Context | None = None) -> None:
    """Shut a context down unless that has happened; a default context is replaced."""
    ending = context or _default.get()
    ending.try_shutdown()
    if context is None and not ending.ok():
        _default.give_up(ending)


def get_rmw_implementation_identifier() -> str:
    """Name of the wire protocol's implementation, of which this is a speaker."""
    return "rmw_cyclonedds_cpp"


def get_available_rmw_implementations() -> set[str]:
    """Names of the implementations to choose from."""
    return {get_rmw_implementation_identifier()}


def timeout_sec_to_nsec(timeout_sec: float | None) -> int:
    """Nanoseconds of a timeout; -1, for ever, if it is None or negative."""
    if timeout_sec is None or timeout_sec < 0:
        return -1
    return int(float(timeout_sec) * S_TO_NS)
