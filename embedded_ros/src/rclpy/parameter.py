"""Parameters: a name, a type and a value."""

from __future__ import annotations

import array
from enum import Enum
from pathlib import Path
from typing import Any, Final

import yaml

__all__ = [
    "PARAMETER_SEPARATOR_STRING",
    "Parameter",
    "get_parameter_value",
    "parameter_dict_from_yaml_file",
    "parameter_value_to_python",
]

PARAMETER_SEPARATOR_STRING: Final = "."

_SEQUENCES = (list, tuple, array.array)


class Parameter:
    """A named value.

    Parameters
    ----------
    name : str
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

    class Type(Enum):
        """Types of values; the numbers are those of ``rcl_interfaces/msg/ParameterType``."""

        NOT_SET = 0
        BOOL = 1
        INTEGER = 2
        DOUBLE = 3
        STRING = 4
        BYTE_ARRAY = 5
        BOOL_ARRAY = 6
        INTEGER_ARRAY = 7
        DOUBLE_ARRAY = 8
        STRING_ARRAY = 9

        @classmethod
        def from_parameter_value(cls, parameter_value: Any) -> Parameter.Type:
            """Type that fits a value. An empty list is taken for a list of bytes."""
            if parameter_value is None:
                return Parameter.Type.NOT_SET
            if isinstance(parameter_value, _SEQUENCES):
                for element, type_ in _ARRAY_ELEMENTS:
                    if all(isinstance(item, element) for item in parameter_value):
                        return type_
                raise TypeError(
                    "The given value is not a list of one of the allowed types "
                    f"'{parameter_value}'."
                )
            for scalar, type_ in _SCALARS:
                if isinstance(parameter_value, scalar):
                    return type_
            raise TypeError(f"The given value is not one of the allowed types '{parameter_value}'.")

        def check(self, parameter_value: Any) -> bool:
            """Tell whether a value is of this type."""
            if self is Parameter.Type.NOT_SET:
                return parameter_value is None
            for scalar, type_ in _SCALARS:
                if self is type_:
                    return isinstance(parameter_value, scalar)
            numeric = self in (Parameter.Type.INTEGER_ARRAY, Parameter.Type.DOUBLE_ARRAY)
            if not isinstance(parameter_value, _SEQUENCES if numeric else (list, tuple)):
                return False
            element = next(element for element, type_ in _ARRAY_ELEMENTS if type_ is self)
            return all(
                isinstance(item, element) and (not isinstance(item, bytes) or len(item) == 1)
                for item in parameter_value
            )

    @classmethod
    def from_parameter_msg(cls, param_msg: Any) -> Parameter:
        """Convert from an ``rcl_interfaces.msg.Parameter``."""
        type_ = Parameter.Type(param_msg.value.type)
        field = _FIELDS.get(type_.value)
        return cls(param_msg.name, type_, getattr(param_msg.value, field) if field else None)

    def __init__(self, name: str, type_: Parameter.Type | None = None, value: Any = None) -> None:
        if type_ is None:
            type_ = Parameter.Type.from_parameter_value(value)
        if not isinstance(type_, Parameter.Type):
            raise TypeError(f"type must be an instance of '{Parameter.Type!r}'")
        if not type_.check(value):
            raise ValueError(f"Type '{type_}' and value '{value}' do not agree")
        self._type_ = type_
        self._name = name
        self._value = value

    def __repr__(self) -> str:
        return f"Parameter({self._name!r}, {self._type_}, {self._value!r})"

    @property
    def name(self) -> str:
        """Name with its prefixes."""
        return self._name

    @property
    def type_(self) -> Parameter.Type:
        """Type of the value."""
        return self._type_

    @property
    def value(self) -> Any:
        """Value; None if not set."""
        return self._value

    def get_parameter_value(self) -> Any:
        """Convert the value to an ``rcl_interfaces.msg.ParameterValue``."""
        from rcl_interfaces.msg import ParameterValue

        message = ParameterValue(type=self._type_.value)
        field = _FIELDS.get(self._type_.value)
        if field:
            setattr(message, field, self._value)
        return message

    def to_parameter_msg(self) -> Any:
        """Convert to an ``rcl_interfaces.msg.Parameter``."""
        from rcl_interfaces.msg import Parameter as ParameterMsg

        return ParameterMsg(name=self._name, value=self.get_parameter_value())


# In the order in which a value is tried: a bool is an int, too.
_SCALARS: tuple[tuple[type, Parameter.Type], ...] = (
    (bool, Parameter.Type.BOOL),
    (int, Parameter.Type.INTEGER),
    (float, Parameter.Type.DOUBLE),
    (str, Parameter.Type.STRING),
)
_ARRAY_ELEMENTS: tuple[tuple[type, Parameter.Type], ...] = (
    (bytes, Parameter.Type.BYTE_ARRAY),
    (bool, Parameter.Type.BOOL_ARRAY),
    (int, Parameter.Type.INTEGER_ARRAY),
    (float, Parameter.Type.DOUBLE_ARRAY),
    (str, Parameter.Type.STRING_ARRAY),
)
_FIELDS: dict[int, str] = {
    type_.value: f"{type_.name.lower()}_value"
    for type_ in Parameter.Type
    if type_ is not Parameter.Type.NOT_SET
}


def get_parameter_value(string_value: str) -> Any:
    """Make an ``rcl_interfaces.msg.ParameterValue`` of a text as a command line has it."""
    try:
        value = yaml.safe_load(string_value)
    except yaml.YAMLError:
        value = string_value
    if value is None or isinstance(value, dict):
        value = string_value
    try:
        type_ = Parameter.Type.from_parameter_value(value)
        if type_ is Parameter.Type.BYTE_ARRAY:  # an empty list: rclpy tries bool first
            type_ = Parameter.Type.BOOL_ARRAY
    except TypeError:
        value, type_ = string_value, Parameter.Type.STRING
    return Parameter("", type_, value).get_parameter_value()


def parameter_value_to_python(parameter_value: Any) -> Any:
    """Value of an ``rcl_interfaces.msg.ParameterValue``; None if not set."""
    try:
        type_ = Parameter.Type(parameter_value.type)
    except ValueError:
        raise RuntimeError(f"unexpected parameter type {parameter_value.type}") from None
    if type_ is Parameter.Type.NOT_SET:
        return None
    value = getattr(parameter_value, _FIELDS[type_.value])
    return list(value) if type_.name.endswith("ARRAY") else value


def parameter_dict_from_yaml_file(
    parameter_file: str,
    use_wildcard: bool = False,
    target_nodes: list[str] | None = None,
    namespace: str = "",
) -> dict[str, Any]:
    """Read a parameter file.

    Parameters
    ----------
    parameter_file : str
    use_wildcard : bool
        Whether to take the parameters of ``/**``, too.
    target_nodes : list of str, optional
        Nodes of the file whose parameters to take; all by default.
    namespace : str
        Put before every parameter name.

    Returns
    -------
    dict
        ``rcl_interfaces.msg.Parameter`` by name.

    Raises
    ------
    RuntimeError
        If the file is no parameter file or lacks a node.
    """
    content = yaml.safe_load(Path(parameter_file).read_text(encoding="utf-8")) or {}
    if not isinstance(content, dict):
        raise RuntimeError(f"YAML file is not a valid ROS parameter file: {parameter_file}")
    for node in target_nodes or ():
        if node not in content:
            raise RuntimeError(
                f"Param file does not contain parameters for {node},"
                f"only for nodes: {list(content)} "
            )
    keys = list(target_nodes or (key for key in content if key != "/**"))
    if use_wildcard and "/**" in content:
        keys.insert(0, "/**")
    if not keys:
        raise RuntimeError("Param file does not contain selected parameters")
    merged: dict[str, Any] = {}
    for key in keys:
        value = content[key]
        if not isinstance(value, dict) or "ros__parameters" not in value:
            raise RuntimeError(f"YAML file is not a valid ROS parameter file for node {key}")
        merged.update(value["ros__parameters"])
    return _flattened(namespace, merged)


def _flattened(namespace: str, values: dict[str, Any]) -> dict[str, Any]:
    from rcl_interfaces.msg import Parameter as ParameterMsg

    parameters: dict[str, Any] = {}
    for name, value in values.items():
        full_name = f"{namespace}{name}"
        if isinstance(value, dict):
            parameters |= _flattened(f"{full_name}{PARAMETER_SEPARATOR_STRING}", value)
        else:
            parameters[full_name] = ParameterMsg(
                name=full_name, value=get_parameter_value(str(value))
            )
    return parameters
