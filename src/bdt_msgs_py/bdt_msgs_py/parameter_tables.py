"""Parameter tables: which dataclasses a node's parameters come from, without a node.

A node declares its table (:mod:`bdt_msgs_py.node_parameters`); what checks a parameter file, an
option or a bag looks into the same table here.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, replace
from difflib import get_close_matches
from typing import Any

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.quantities import Quantity, check, quantities_of


class ReadAtStart(str):
    """Prefix of what a node takes when it starts and not later, though another node might."""

    __slots__ = ()


ParameterTable = Sequence[tuple[str, type[Any]]]
"""Prefixes and dataclasses, in the order in which a node declares them."""


def known_parameters(table: ParameterTable) -> dict[str, tuple[Any, Quantity]]:
    """Return default and quantity of every parameter of a table by flat name."""
    return {
        full_name(prefix, name): (
            default,
            replace(described, reconfigurable=False)
            if isinstance(prefix, ReadAtStart)
            else described,
        )
        for prefix, kind in table
        for name, default, described in quantities_of(kind)
    }


def full_name(prefix: str, name: str) -> str:
    """Return the name of a parameter: ``motor.inductance`` for `prefix` ``motor``."""
    return f"{prefix}.{name}" if prefix else name


def parameter_sets(table: ParameterTable, values: Mapping[str, Any]) -> list[Any]:
    """Return the dataclasses of a table with the values in force, in its order.

    Parameters
    ----------
    table : ParameterTable
        The node's parameters.
    values : mapping of str
        Values by flat name, each of which was checked; the default holds for what is missing.

    Raises
    ------
    ValueError
        If values do not go together, with one line that says which.
    """
    known = known_parameters(table)
    built = []
    for prefix, kind in table:
        given = {}
        for item in fields(kind):
            name = full_name(prefix, item.name)
            value = values[name] if name in values else known[name][0]
            given[item.name] = tuple(value) if isinstance(value, list) else value
        built.append(kind(**given))
    return built


def check_value(label: str, value: Any, default: Any, described: Quantity) -> None:
    """Check one value as strictly as the node would.

    Parameters
    ----------
    label : str
        What the message calls it.
    value, default, described
        See :func:`bdt_msgs_py.quantities.check`.

    Raises
    ------
    BadInputError
        With one line that names the parameter, the value and what is allowed.
    """
    # ROS parameters are typed: a node would refuse the integer 5 where 5.0 is wanted.
    items = value if isinstance(value, list) else [value]
    first = default[0] if isinstance(default, tuple) else default
    if isinstance(first, float) and any(type(item) is int for item in items):
        raise BadInputError(f"{label} = {value!r}: must be written with a decimal point")
    try:
        check(label, value, default, described)
    except ValueError as error:
        raise BadInputError(str(error)) from error


def in_parameter_names(text: str, table: ParameterTable) -> str:
    """Return a message of a parameter dataclass with the names that the parameters have in ROS."""
    for prefix, kind in table:
        text = text.replace(f"{kind.__name__}.", full_name(prefix, ""))
    return text


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return the end of a message about an unknown name: the name that was meant, if any."""
    close = get_close_matches(name, known, n=1)
    return f"; did you mean {close[0]}?" if close else ""


def ros_arguments(parameters: Mapping[str, Any]) -> list[str]:
    """Return parameters as ``--ros-args`` takes them: ``-p name:=value``, the value as YAML."""
    return [
        text
        for name, value in parameters.items()
        for text in ("-p", f"{name}:={json.dumps(value)}")
    ]
