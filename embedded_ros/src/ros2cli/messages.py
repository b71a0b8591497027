"""Messages by the names of their types, and to and from YAML."""

import importlib
from collections.abc import Mapping
from typing import Any

import yaml

from ros2cli.errors import CommandError

__all__ = ["fill", "import_type", "parse_values", "to_plain", "to_yaml"]


def import_type(name: str) -> Any:
    """Class of a type name such as ``std_msgs/msg/String`` or ``std_srvs/srv/Trigger``."""
    parts = name.split("/")
    try:
        package, kind, short = parts
        return getattr(importlib.import_module(f"{package}.{kind}"), short)
    except (ValueError, ImportError, AttributeError):
        raise CommandError(f"The type '{name}' is invalid or not available") from None


def to_plain(value: Any) -> Any:
    """Make a message a dict of dicts, lists and scalars."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: to_plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, bytes):
        return list(value) if len(value) != 1 else value[0]
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [to_plain(item) for item in value]
    return value


def to_yaml(message: Any) -> str:
    """Write a message as ``ros2 topic echo`` does."""
    plain = to_plain(message)
    return yaml.dump(plain, sort_keys=False, default_flow_style=False, allow_unicode=True)


def parse_values(text: str) -> dict[str, Any]:
    """Read the field values of a command line."""
    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise CommandError(
            f"The passed value needs to be a dictionary in YAML format: {error}"
        ) from None
    if values is None:
        return {}
    if not isinstance(values, dict):
        raise CommandError("The passed value needs to be a dictionary in YAML format")
    return values


def fill(message: Any, values: Mapping[str, Any]) -> Any:
    """Set fields of a message, nested ones from nested dicts."""
    types = message.get_fields_and_field_types()
    for name, value in values.items():
        if name not in types:
            raise CommandError(f"Failed to populate field: '{name}' is no field of {message!r}")
        try:
            setattr(message, name, _field_value(getattr(message, name), types[name], value))
        except (TypeError, ValueError, OverflowError) as error:
            raise CommandError(f"Failed to populate field: '{name}': {error}") from None
    return message


def _field_value(current: Any, type_name: str, value: Any) -> Any:
    if hasattr(current, "get_fields_and_field_types"):
        return fill(current, value or {})
    if type_name.startswith("sequence<") and "/" in type_name:
        package, short = (
            type_name[len("sequence<") :].split(",", maxsplit=1)[0].rstrip(">").split("/")
        )
        element = import_type(f"{package}/msg/{short}")
        return [fill(element(), item) for item in value]
    if isinstance(current, float) and not isinstance(value, bool):
        return float(value)
    if isinstance(current, bytes):
        return bytes([int(value)])
    if type_name.startswith("string") and not isinstance(value, str):
        return str(value)
    return value
