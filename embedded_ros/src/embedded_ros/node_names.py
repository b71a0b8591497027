"""The names of a node and of what it makes, as the command line has them."""

from collections.abc import Callable, Iterable
from typing import TypeVar

from embedded_ros.argument_encoding import check_encoding
from embedded_ros.errors import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    RCLError,
    RCLInvalidROSArgsError,
)
from embedded_ros.names import (
    IS_INVALID,
    expand,
    expand_valid,
    full_topic_name_error,
    join,
    namespace_error,
    node_name_error,
)
from embedded_ros.ros_arguments import RosArguments, parse_arguments

__all__ = ["NodeNames", "arguments_of_node"]

_T = TypeVar("_T")


def arguments_of_node(words: list[str] | None) -> tuple[RosArguments, ...]:
    """Arguments that are given to a node alone.

    Raises
    ------
    RCLInvalidROSArgsError
        If one is malformed or not UTF-8.
    """
    try:
        check_encoding(words or ())
        return (parse_arguments(words),) if words else ()
    except (RCLInvalidROSArgsError, UnicodeEncodeError) as error:
        raise RCLInvalidROSArgsError(f"Failed to parse ROS arguments: {error}") from None


class NodeNames:
    """Name and namespace of a node, and the full names of its topics and services.

    Parameters
    ----------
    name, namespace : str
        As the program gives them.
    arguments : tuple of RosArguments
        What applies to the node; of several that rename the same thing the first counts.

    Raises
    ------
    InvalidNodeNameException, InvalidNamespaceException
    """

    def __init__(self, name: str, namespace: str, arguments: tuple[RosArguments, ...]) -> None:
        self.arguments = arguments
        absolute = namespace if namespace.startswith("/") else f"/{namespace}"
        _check(name, absolute)
        self.name = _first(each.node_name(name) for each in arguments) or name
        # Rules for the namespace go by the new name, as rcl has it.
        self.namespace = _first(each.namespace(self.name) for each in arguments) or absolute
        _check(self.name, self.namespace)

    @property
    def fully_qualified(self) -> str:
        """Namespace and name."""
        return join(self.namespace, self.name)

    @property
    def logger(self) -> str:
        """Name of the node's logger."""
        return self.fully_qualified.strip("/").replace("/", ".")

    def says(self, switch: str) -> bool:
        """Tell whether the command line has a switch such as ``--disable-rosout-logs``."""
        return any(switch in each.switches for each in self.arguments)

    def full_name(self, name: str, *, is_service: bool = False) -> str:
        """Expand and remap a name for an endpoint; an invalid one is an exception of its kind."""
        expanded = expand_valid(name, self.name, self.namespace, is_service=is_service)
        return self._remapped(expanded, is_service)

    def resolve(self, name: str, *, is_service: bool, only_expand: bool) -> str:
        """Expand and remap a name that is asked about; ``RCLError`` if it is invalid."""
        try:
            expanded = expand(name, self.name, self.namespace)
        except ValueError as error:
            reason: str | None = str(error).partition(IS_INVALID)[2]
        else:
            fault = full_topic_name_error(expanded)
            reason = None if fault is None else fault[0]
        if reason is not None:
            raise RCLError(f"failed to resolve name: {reason}")
        return expanded if only_expand else self._remapped(expanded, is_service)

    def _remapped(self, full_name: str, is_service: bool) -> str:
        remappings = (
            each.remap(full_name, self.name, self.namespace, is_service=is_service)
            for each in self.arguments
        )
        found = _first(remappings)
        return full_name if found is None else found


def _first(candidates: Iterable[_T | None]) -> _T | None:
    return next((candidate for candidate in candidates if candidate is not None), None)


def _check(name: str, namespace: str) -> None:
    checks: tuple[
        tuple[str, Callable[[str], tuple[str, int] | None], Callable[..., Exception]], ...
    ] = (
        (name, node_name_error, InvalidNodeNameException),
        (namespace, namespace_error, InvalidNamespaceException),
    )
    for value, fault_of, error in checks:
        fault = fault_of(value)
        if fault is not None:
            raise error(value, *fault)
