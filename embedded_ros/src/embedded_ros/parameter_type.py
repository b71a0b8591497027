"""Types of parameters: a table of what the values of each are.

Inferring a type, checking a value and finding its field in a message look it up.
"""

from __future__ import annotations

import array
from collections.abc import Iterable
from enum import Enum
from typing import Any, Final, NamedTuple

__all__ = ["ParameterType", "value_field"]


class ParameterType(Enum):
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
    def from_parameter_value(cls, parameter_value: Any) -> ParameterType:
        """ParameterType that fits a value; an empty list is taken for a list of bytes.

        Raises
        ------
        TypeError
            If no type fits.
        """
        if parameter_value is None:
            return cls.NOT_SET
        if not isinstance(parameter_value, _ARRAYS):
            found = _TYPE_OF_SCALAR.get(_kind(parameter_value))
            if found is None:
                raise TypeError(
                    f"The given value is not one of the allowed types '{parameter_value}'."
                )
            return found
        kinds = {_kind(item) for item in parameter_value} or {bytes}
        if kinds == {bool, int}:
            kinds = {int}
        found = _TYPE_OF_ELEMENTS.get(kinds.pop()) if len(kinds) == 1 else None
        if found is None:
            raise TypeError(
                f"The given value is not a list of one of the allowed types '{parameter_value}'."
            )
        return found

    def check(self, parameter_value: Any) -> bool:
        """Tell whether a value is of this type."""
        python_type, holders = _ROWS[self]
        if holders is None:
            return isinstance(parameter_value, python_type)
        return isinstance(parameter_value, holders) and all(
            isinstance(item, python_type) and (not isinstance(item, bytes) or len(item) == 1)
            for item in parameter_value
        )


# Programs know it as Parameter.Type: so it is in texts and pickles.
ParameterType.__name__ = "Type"
ParameterType.__qualname__ = "Parameter.Type"


class _Row(NamedTuple):
    """What the values of a type are."""

    python_type: type
    holders: tuple[type[Iterable[object]], ...] | None = None


_LISTS = (list, tuple)
_ARRAYS = (*_LISTS, array.array)
_ROWS: Final = {
    ParameterType.NOT_SET: _Row(type(None)),
    ParameterType.BOOL: _Row(bool),
    ParameterType.INTEGER: _Row(int),
    ParameterType.DOUBLE: _Row(float),
    ParameterType.STRING: _Row(str),
    ParameterType.BYTE_ARRAY: _Row(bytes, _LISTS),
    ParameterType.BOOL_ARRAY: _Row(bool, _LISTS),
    ParameterType.INTEGER_ARRAY: _Row(int, _ARRAYS),
    ParameterType.DOUBLE_ARRAY: _Row(float, _ARRAYS),
    ParameterType.STRING_ARRAY: _Row(str, _LISTS),
}
_TYPE_OF_SCALAR = {row.python_type: type_ for type_, row in _ROWS.items() if row.holders is None}
_TYPE_OF_ELEMENTS = {row.python_type: type_ for type_, row in _ROWS.items() if row.holders}


def _kind(item: Any) -> type:
    """Python type of the table that an object is of; a bool is no int here."""
    for python_type in (bool, int, float, str, bytes):
        if isinstance(item, python_type):
            return python_type
    return type(item)


_FIELDS = {
    type_.value: None if type_ is ParameterType.NOT_SET else f"{type_.name.lower()}_value"
    for type_ in ParameterType
}


def value_field(number: int) -> str | None:
    """Field of ``rcl_interfaces/msg/ParameterValue`` that holds a type's value.

    Raises
    ------
    ValueError
        If `number` is that of no type.
    """
    if number not in _FIELDS:
        raise ValueError(f"{number} is no type of parameters")
    return _FIELDS[number]
