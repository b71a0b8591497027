"""A parameter: a name, a type and a value; and its message."""

from __future__ import annotations

from typing import Any, TypeAlias

from embedded_ros.message_classes import message_class
from embedded_ros.parameter_type import ParameterType, value_field

__all__ = ["Parameter"]


class Parameter:
    """A named value.

    Parameters
    ----------
    name : str
        With its prefixes, which dots separate.
    type_ : Parameter.Type, optional
        Inferred from `value` by default.
    value : bool, int, float, str, or a list of one of these or of bytes; optional

    Raises
    ------
    TypeError
        If no type fits the value.
    ValueError
        If the value is not of the type.
    """

    Type: TypeAlias = ParameterType

    def __init__(self, name: str, type_: ParameterType | None = None, value: Any = None) -> None:
        self._content = (name, _agreed(type_, value), value)

    @classmethod
    def from_parameter_msg(cls, param_msg: Any) -> Parameter:
        """Convert from an ``rcl_interfaces.msg.Parameter``; ``ValueError`` if its type is none."""
        message = param_msg.value
        field = value_field(message.type)
        return cls(param_msg.name, ParameterType(message.type), field and getattr(message, field))

    def __repr__(self) -> str:
        name, type_, value = self._content
        return f"Parameter({name!r}, {type_}, {value!r})"

    @property
    def name(self) -> str:
        """Name with its prefixes."""
        return self._content[0]

    @property
    def type_(self) -> ParameterType:
        """Type of the value."""
        return self._content[1]

    @property
    def value(self) -> Any:
        """Value; None if not set."""
        return self._content[2]

    def get_parameter_value(self) -> Any:
        """Convert the value to an ``rcl_interfaces.msg.ParameterValue``."""
        _, type_, value = self._content
        field = value_field(type_.value)
        filled = {} if field is None else {field: value}
        return message_class("rcl_interfaces/msg/ParameterValue")(type=type_.value, **filled)

    def to_parameter_msg(self) -> Any:
        """Convert to an ``rcl_interfaces.msg.Parameter``."""
        return message_class("rcl_interfaces/msg/Parameter")(
            name=self.name, value=self.get_parameter_value()
        )


def _agreed(type_: ParameterType | None, value: Any) -> ParameterType:
    """Type that was given, or else the one that fits the value, if the value is of it."""
    match type_ or ParameterType.from_parameter_value(value):
        case ParameterType() as agreed if agreed.check(value):
            return agreed
        case ParameterType() as wrong:
            raise ValueError(f"Type '{wrong}' and value '{value}' do not agree")
    raise TypeError(f"type must be an instance of '{ParameterType!r}'")
