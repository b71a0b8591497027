"""What a declaration says: its name, its value or only its type, and its descriptor."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from embedded_ros.errors import InvalidParameterException
from embedded_ros.message_classes import message_class
from embedded_ros.parameter_selection import SEPARATOR
from embedded_ros.parameter_type import ParameterType

__all__ = ["Declaration", "read_declarations"]


class Declaration(NamedTuple):
    """A checked declaration.

    Attributes
    ----------
    name : str
        Full name.
    value : object
        Default; None if there is none.
    descriptor : rcl_interfaces.msg.ParameterDescriptor
    is_name_only : bool
        Nothing but the name was given, which is deprecated.
    """

    name: str
    value: Any
    descriptor: Any
    is_name_only: bool


def read_declarations(namespace: str, entries: Iterable[Sequence[Any]]) -> list[Declaration]:
    """Check what ``declare_parameters`` takes.

    Parameters
    ----------
    namespace : str
        Put with a separator before every name, unless it is empty.
    entries : iterable of (name, value or Type, descriptor)
        Value and descriptor may be missing.

    Raises
    ------
    TypeError
        If an entry is too long or short or its name or descriptor is none.
    InvalidParameterException
        If a name is empty.
    ValueError
        If a parameter is to have a fixed type and has none, or is given one although it has not.
    """
    prefix = f"{namespace}{SEPARATOR}" if namespace else ""
    return [_read(prefix, index, *_parts(index, entry)) for index, entry in enumerate(entries)]


def _parts(index: int, entry: Sequence[Any]) -> tuple[Any, Any, Any, bool]:
    match tuple(entry):
        case (name,):
            return name, None, _dynamic_descriptor(), True
        case (name, value):
            return name, value, message_class("rcl_interfaces/msg/ParameterDescriptor")(), False
        case (name, value, descriptor):
            return name, value, descriptor, False
    raise TypeError(
        f"Invalid parameter tuple length at index {index} in parameters list: "
        f"{entry}; expecting length between 1 and 3"
    )


def _dynamic_descriptor() -> Any:
    return message_class("rcl_interfaces/msg/ParameterDescriptor")(dynamic_typing=True)


def _read(
    prefix: str, index: int, name: Any, value: Any, descriptor: Any, is_name_only: bool
) -> Declaration:
    if not isinstance(name, str):
        raise TypeError(f"First element {name} at index {index} in parameters list is not a str.")
    if not prefix + name:
        raise InvalidParameterException(name)
    if not isinstance(descriptor, message_class("rcl_interfaces/msg/ParameterDescriptor")):
        raise TypeError(
            f"Third element {descriptor} at index {index} in parameters list "
            "is not a ParameterDescriptor."
        )
    name = prefix + name
    type_ = value if isinstance(value, ParameterType) else None
    if type_ is not None:
        value = None
        if type_ is ParameterType.NOT_SET:
            raise ValueError(
                f"Cannot declare parameter {{{name}}} as statically typed of type NOT_SET"
            )
        if descriptor.dynamic_typing:
            raise ValueError(
                f"When declaring parameter {{{name}}} passing a descriptor with"
                "`dynamic_typing=True` is not allowed when the parameter type is provided"
            )
    elif not descriptor.dynamic_typing:
        type_ = ParameterType.from_parameter_value(value)
        if type_ is ParameterType.NOT_SET:
            raise ValueError(
                "Cannot declare a statically typed parameter with default value "
                "of type PARAMETER_NOT_SET"
            )
    if type_ is not None:
        descriptor.type = type_.value
    return Declaration(name, value, descriptor, is_name_only)
