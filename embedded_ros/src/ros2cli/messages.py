"""Messages by the names of their types, filled with values from YAML."""

import importlib
import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import yaml

from rclpy.serialization import serialize_message
from ros2cli.errors import CommandError, did_you_mean, one_line
from ros2cli.interface_texts import interface_names

__all__ = ["Stamp", "import_type", "message_of", "parse_values"]

_NOUNS = {"msg": "message", "srv": "service"}

#: Takes a time, and puts it where the command line says ``auto`` or ``now``.
Stamp = Callable[[Any], None]


def import_type(name: str, kind: str) -> Any:
    """Class of a type.

    Parameters
    ----------
    name : str
        Such as ``std_msgs/msg/String``, or ``std_msgs/String`` for short.
    kind : {'msg', 'srv'}
        What the type must be.

    Raises
    ------
    CommandError
        If there is none.
    """
    package, _, rest = name.partition("/")
    short = rest.removeprefix(f"{kind}/")
    if package.isidentifier() and short.isidentifier():
        try:
            return getattr(importlib.import_module(f"{package}.{kind}"), short)
        except (ImportError, AttributeError):
            pass
    (other,) = _NOUNS.keys() - {kind}
    if f"/{other}/" in name:
        raise CommandError(f"'{name}' is a {_NOUNS[other]}, not a {_NOUNS[kind]}")
    known = [
        f"{owner}/{kind}/{each}"
        for owner, all_of in interface_names(kind).items()
        for each in all_of
    ]
    raise CommandError(f"Unknown {_NOUNS[kind]} type '{name}'{did_you_mean(name, known)}")


def parse_values(text: str) -> Mapping[str, Any]:
    """Field names and values of a command line, in YAML."""
    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise CommandError(f"'{text}' is not valid YAML: {one_line(error)}") from None
    if not isinstance(values, Mapping):
        raise CommandError(f"'{text}' names no fields: write '{{field: value}}'")
    return values


def message_of(kind: Any, values: Mapping[str, Any]) -> tuple[Any, list[Stamp]]:
    """Make a message, nested ones from nested mappings.

    Raises
    ------
    CommandError
        If it has no such field, or if a value does not fit.
    """
    message = kind()
    stamps: list[Stamp] = []
    _fill(message, values, stamps)
    try:
        # What a field cannot hold shows in its bytes.
        serialize_message(message)
    except (TypeError, ValueError, OverflowError, AssertionError) as error:
        raise CommandError(error) from None
    return message, stamps


def _fill(message: Any, values: Any, stamps: list[Stamp]) -> Any:
    name = type(message).__name__
    if not isinstance(values, Mapping):
        raise CommandError(f"{name} needs '{{field: value}}', not {values!r}")
    types = message.get_fields_and_field_types()
    for field, value in values.items():
        if field not in types:
            fields = ", ".join(types) or "nothing"
            raise CommandError(f"{name} has no field '{field}', but {fields}")
        try:
            if types[field] == "std_msgs/Header" and value == "auto":
                stamps.append(partial(setattr, getattr(message, field), "stamp"))
            elif types[field] == "builtin_interfaces/Time" and value == "now":
                stamps.append(partial(setattr, message, field))
            else:
                filled = _value(getattr(message, field), types[field], value, stamps)
                setattr(message, field, filled)
        except (TypeError, ValueError, OverflowError, AssertionError) as error:
            raise CommandError(
                f"{name}.{field} is {types[field]} and cannot be {value!r}: {error}"
            ) from None
    return message


def _value(current: Any, type_name: str, value: Any, stamps: list[Stamp]) -> Any:
    """What YAML has for a field, as the class wants it."""
    element = re.match(r"(?:sequence<)?([\w/]+)", type_name)[1]  # type: ignore[index]
    nested = "/" in element
    if type_name.startswith("sequence<") or type_name.endswith("]"):
        if isinstance(value, str):
            raise TypeError("a list is needed")
        if nested:
            owner, _, short = element.partition("/")
            kind = import_type(f"{owner}/msg/{short}", "msg")
            return [_fill(kind(), item, stamps) for item in value]
        return [float(item) for item in value] if element in ("double", "float") else value
    if nested:
        return _fill(current, value, stamps)
    if isinstance(current, bytes):
        return bytes([int(value)])
    if isinstance(current, bool) and not isinstance(value, bool | int):
        raise TypeError("true or false is needed")
    if isinstance(current, int) and isinstance(value, float) and not value.is_integer():
        raise TypeError("an integer is needed")
    return type(current)(value)
