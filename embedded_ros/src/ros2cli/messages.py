"""Messages by the names of their types, and filled with values from YAML."""

import importlib
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import yaml

from ros2cli.errors import CommandError

__all__ = ["fill", "import_type", "parse_values"]


def import_type(name: str, kind: str, complaint: str) -> Any:
    """Class of a type.

    Parameters
    ----------
    name : str
        Such as ``std_msgs/msg/String``, or ``std_msgs/String`` for short.
    kind : {'msg', 'srv'}
        What the type must be.
    complaint : str
        What the user is told if there is no such type.
    """
    package, _, rest = name.partition("/")
    short = rest.removeprefix(f"{kind}/")
    try:
        if not package.isidentifier() or not short.isidentifier():
            raise CommandError(complaint)
        found = getattr(importlib.import_module(f"{package}.{kind}"), short)
    except (ImportError, AttributeError):
        raise CommandError(complaint) from None
    return found


def parse_values(text: str) -> dict[str, Any]:
    """Read the field values of a command line."""
    complaint = "The passed value needs to be a dictionary in YAML format"
    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise CommandError(f"{complaint}: {' '.join(str(error).split())}") from None
    if not isinstance(values, dict):
        raise CommandError(complaint)
    return values


def fill(message: Any, values: Mapping[str, Any]) -> list[Callable[[Any], None]]:
    """Set fields of a message, nested ones from nested dicts.

    Returns
    -------
    list of callable
        They take a time and set the stamps for which ``auto`` (a header) or ``now`` was given.
    """
    stamps: list[Callable[[Any], None]] = []
    try:
        _fill(message, values, stamps)
    except (AttributeError, TypeError, ValueError, OverflowError, AssertionError) as error:
        raise CommandError(f"Failed to populate field: {' '.join(str(error).split())}") from None
    return stamps


def _fill(message: Any, values: Any, stamps: list[Callable[[Any], None]]) -> Any:
    if not isinstance(values, Mapping):
        kind = type(values).__name__
        raise TypeError(f"Value '{values}' is expected to be a dictionary but is a {kind}")
    types = message.get_fields_and_field_types()
    for name, value in values.items():
        if name not in types:
            raise AttributeError(f"'{type(message).__name__}' object has no attribute '{name}'")
        current = getattr(message, name)
        if types[name] == "std_msgs/Header" and value == "auto":
            stamps.append(partial(setattr, current, "stamp"))
        elif types[name] == "builtin_interfaces/Time" and value == "now":
            stamps.append(partial(setattr, message, name))
        else:
            setattr(message, name, _field_value(current, types[name], value, stamps))
    return message


def _field_value(
    current: Any, type_name: str, value: Any, stamps: list[Callable[[Any], None]]
) -> Any:
    if hasattr(current, "get_fields_and_field_types"):
        return _fill(current, value, stamps)
    element = type_name.removeprefix("sequence<").rstrip(">").partition(",")[0].partition("[")[0]
    if element != type_name and "/" in element:
        package, _, short = element.partition("/")
        element_class = import_type(f"{package}/msg/{short}", "msg", f"No type {element}")
        return [_fill(element_class(), item, stamps) for item in value]
    if isinstance(current, bytes):
        return bytes([int(value)])
    if isinstance(current, bool | int | float | str):
        return type(current)(value)
    if element in ("double", "float"):
        return [float(item) for item in value]
    return value
