"""Parameter dataclasses as ROS parameters: declared with descriptors, read back, validated."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, TypeVar

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_tables import ParameterTable, ReadAtStart, full_name
from bdt_msgs_py.quantities import Quantity, check, quantities_of

Parameters = TypeVar("Parameters")


class ConfigurationError(BadInputError):
    """A parameter that a user can set is unknown, of the wrong type or out of range."""


def declare(node: Node, prefix: str, parameters: type[Parameters]) -> Parameters:
    """Declare every field of a parameter dataclass and return it with the values in force.

    Parameters
    ----------
    node : rclpy.node.Node
        Node that gets the parameters.
    prefix : str
        For example ``motor`` for parameters named ``motor.inductance``; may be empty. Below a
        :class:`ReadAtStart` all are read-only.
    parameters : type
        Dataclass whose fields are quantities, each with a default.

    Raises
    ------
    ConfigurationError
        With one line that names the parameter, the value and what is allowed.
    """
    values = {}
    for name, default, described in quantities_of(parameters):
        parameter = full_name(prefix, name)
        initial = list(default) if isinstance(default, tuple) else default
        descriptor = _descriptor(default, described)
        descriptor.read_only = isinstance(prefix, ReadAtStart) or not described.reconfigurable
        try:
            value = node.declare_parameter(parameter, initial, descriptor).value
        except ParameterException as error:
            given = _override(node, parameter)
            raise ConfigurationError(
                f"parameter {parameter} = {given!r}: must be {described.rule(_type_name(default))}"
            ) from error
        values[name] = tuple(value) if isinstance(default, tuple) else value
        try:
            check(f"parameter {parameter}", values[name], default, described)
        except ValueError as error:
            raise ConfigurationError(str(error)) from error
    try:
        return parameters(**values)
    except ValueError as error:
        raise ConfigurationError(str(error)) from error


def declare_all(node: Node, parameters: ParameterTable) -> list[Any]:
    """Declare all parameters of a node and refuse values given for any other name.

    Parameters
    ----------
    node : rclpy.node.Node
        Node that gets the parameters.
    parameters : ParameterTable
        Prefixes and dataclasses, see :func:`declare`.

    Returns
    -------
    list
        One instance of each dataclass, with the values in force.

    Raises
    ------
    ConfigurationError
        With one line that names the parameter, the value and what is allowed. rclpy alone would
        ignore a misspelt name.
    """
    with destroy_on_error(node):
        declared = [declare(node, prefix, kind) for prefix, kind in parameters]
        # rclpy has no public way to see the overrides of parameters that were never declared.
        for name, override in node._parameter_overrides.items():
            if not node.has_parameter(name) and not name.startswith("qos_overrides."):
                raise ConfigurationError(
                    f"parameter {name} = {override.value!r}: "
                    f"is not a parameter of {node.get_fully_qualified_name()}"
                )
    return declared


def declare_options(node: Node, prefix: str) -> dict[str, Any]:
    """Declare the parameters that were given below a prefix, whatever their names are.

    For code from outside this project, which alone knows what it takes.

    Parameters
    ----------
    node : rclpy.node.Node
        Node that gets the parameters, all read-only.
    prefix : str
        For example ``drive`` for parameters named ``drive.port``.

    Returns
    -------
    dict
        Values by the names without the prefix.
    """
    given = {
        name: override.value
        for name, override in node._parameter_overrides.items()
        if name.startswith(f"{prefix}.")
    }
    for name, value in given.items():
        node.declare_parameter(name, value, ParameterDescriptor(read_only=True))
    return {name.removeprefix(f"{prefix}."): value for name, value in given.items()}


@contextmanager
def destroy_on_error(node: Node) -> Iterator[None]:
    """Destroy a node whose configuration is refused within the ``with`` block.

    Its constructor raises, so nobody holds it; yet it would stay in the graph for its peers to
    see until Python collects it, which may take minutes.

    Parameters
    ----------
    node : rclpy.node.Node
        Node under construction.
    """
    try:
        yield
    except ConfigurationError:
        node.destroy_node()
        raise


def reconfigured(current: Parameters, prefix: str, changes: list[Parameter]) -> Parameters:
    """Return `current` with the changes that concern it.

    Parameters
    ----------
    current : dataclass
        Values in force.
    prefix : str
        The prefix it was declared with.
    changes : list of rclpy.parameter.Parameter
        What a caller of the parameter service asks for, of any prefix.

    Raises
    ------
    ValueError
        If the result would not be valid.
    """
    known = {
        full_name(prefix, name): (name, default) for name, default, _ in quantities_of(current)
    }
    values: dict[str, Any] = {}
    for change in changes:
        if change.name in known:
            name, default = known[change.name]
            values[name] = tuple(change.value) if isinstance(default, tuple) else change.value
    return replace(current, **values) if values else current  # type: ignore[type-var]


def accepted() -> SetParametersResult:
    """Return the answer to a valid request of the parameter service."""
    return SetParametersResult(successful=True)


def rejected(reason: str) -> SetParametersResult:
    """Return the answer to an invalid request, with one line that says why."""
    return SetParametersResult(successful=False, reason=reason)


def _override(node: Node, name: str) -> Any:
    override = node._parameter_overrides.get(name)
    return None if override is None else override.value


def _type_name(default: Any) -> str:
    names = {bool: "true or false", int: "an integer", float: "a number like 1.0", str: "a text"}
    if isinstance(default, tuple):
        return f"a list, each {names[type(default[0])]}"
    return names[type(default)]


def _descriptor(default: Any, described: Quantity) -> ParameterDescriptor:
    unit = f" [{described.unit}]" if described.unit else ""
    constraints = _type_name(default) if described.is_free else described.allowed()
    descriptor = ParameterDescriptor(
        description=described.description + unit, additional_constraints=constraints
    )
    low, high = described.minimum, described.maximum
    if low is None or high is None:
        return descriptor
    if type(default) is float:
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high), step=0.0)
        ]
    elif type(default) is int:
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    return descriptor
