"""The checks that rosidl's property setters make when ``check_fields`` is on.

They raise ``AssertionError`` with rosidl's texts. Off by default, as in Jazzy: the environment
variable ``ROS_PYTHON_CHECK_FIELDS=1`` turns them on for every message.
"""

import math
from array import array
from collections import UserList, UserString
from collections.abc import Callable, Sequence, Set
from typing import Any, Final

import numpy as np

from embedded_ros.definitions import Field

__all__ = ["ARRAY_CODES", "make_check"]

#: Type code of ``array.array`` for each primitive that rosidl stores in one.
ARRAY_CODES: Final = {
    "float32": "f",
    "float64": "d",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
}
_DOUBLE_LIMIT = 1.7976931348623157e308
_FLOAT_LIMIT = 3.402823466e38


def _integer_bounds(type_name: str) -> tuple[int, int] | None:
    if type_name.startswith("uint"):
        return 0, 2 ** int(type_name[4:]) - 1
    if type_name.startswith("int"):
        return -(2 ** (int(type_name[3:]) - 1)), 2 ** (int(type_name[3:]) - 1) - 1
    return None


def _python_type(field: Field, message: type | None) -> tuple[type, str]:
    if message is not None:
        return message, message.__name__
    for names, python_type in (
        (("bool",), bool),
        (("byte",), bytes),
        (("string",), str),
        (("float32", "float64"), float),
    ):
        if field.type_name in names:
            return python_type, python_type.__name__
    return int, "int"


def make_check(field: Field, message: type | None) -> Callable[[Any], None]:
    """Make the check of a field.

    Parameters
    ----------
    field : Field
    message : type or None
        Class of the nested message, if the field holds messages.

    Returns
    -------
    callable
        Takes a value; raises ``AssertionError`` if the field cannot hold it.
    """
    if field.container is not None:
        return _container_check(field, message)
    return _scalar_check(field, message)


def _scalar_check(field: Field, message: type | None) -> Callable[[Any], None]:
    python_type, type_text = _python_type(field, message)
    bounds = _integer_bounds(field.type_name)
    start = f"The '{field.name}' field must be"

    def check(value: Any) -> None:
        if message is not None:
            assert isinstance(value, message), f"{start} a sub message of type '{type_text}'"
        elif field.type_name == "byte":
            is_octet = isinstance(value, bytes | bytearray) and len(value) == 1
            assert is_octet, f"{start} of type 'bytes' or 'ByteString' with length 1"
        elif field.string_limit:
            is_short = isinstance(value, str | UserString) and len(value) <= field.string_limit
            assert is_short, f"{start} string value not longer than {field.string_limit}"
        else:
            assert isinstance(value, python_type), f"{start} of type '{type_text}'"
        if bounds is not None:
            kind = "an unsigned integer" if bounds[0] == 0 else "an integer"
            assert bounds[0] <= value <= bounds[1], f"{start} {kind} in [{bounds[0]}, {bounds[1]}]"
        if python_type is float:
            kind, limit = _float_limit(field)
            assert not abs(value) > limit or math.isinf(value), (
                f"{start} a {kind} in [{-limit}, {limit}]"
            )

    return check


def _float_limit(field: Field) -> tuple[str, float]:
    return ("float", _FLOAT_LIMIT) if field.type_name == "float32" else ("double", _DOUBLE_LIMIT)


def _container_check(field: Field, message: type | None) -> Callable[[Any], None]:
    python_type, type_text = _python_type(field, message)
    if message is None and python_type not in (bool, bytes, str, float):
        type_text = "int"
    bounds = _integer_bounds(field.type_name)
    code = ARRAY_CODES.get(field.type_name) if message is None else None
    wanted = ["a set or sequence"]
    if field.container == "array":
        wanted.append(f"with length {field.size}")
    elif field.size:
        wanted.append(f"with length <= {field.size}")
    if field.string_limit:
        wanted.append(f"and each string value not longer than {field.string_limit}")
    wanted.append(f"and each value of type '{type_text}'")
    if bounds is not None:
        kind = "unsigned integer" if bounds[0] == 0 else "integer"
        wanted.append(f"and each {kind} in [{bounds[0]}, {bounds[1]}]")
    elif python_type is float:
        kind, limit = _float_limit(field)
        wanted.append(f"and each {kind} in [{-limit:f}, {limit:f}]")
    text = f"The '{field.name}' field must be {' '.join(wanted)}"

    def holds(value: Any) -> bool:
        if not isinstance(value, Sequence | Set | UserList) or isinstance(value, str | UserString):
            return False
        if field.container == "array" and len(value) != field.size:
            return False
        if field.container == "sequence" and field.size and len(value) > field.size:
            return False
        if not all(isinstance(item, python_type) for item in value):
            return False
        if field.string_limit and any(len(item) > field.string_limit for item in value):
            return False
        if bounds is not None:
            return all(bounds[0] <= item <= bounds[1] for item in value)
        if python_type is float:
            limit = _float_limit(field)[1]
            return all(not abs(item) > limit or math.isinf(item) for item in value)
        return True

    def check(value: Any) -> None:
        start = f"The '{field.name}'"
        if code is not None and field.container == "array" and isinstance(value, np.ndarray):
            dtype = np.dtype(code)
            assert value.dtype == dtype, (
                f"{start} numpy.ndarray() must have the dtype of 'numpy.{dtype.name}'"
            )
            assert value.size == field.size, (
                f"{start} numpy.ndarray() must have a size of {field.size}"
            )
        elif code is not None and field.container == "sequence" and isinstance(value, array):
            assert value.typecode == code, (
                f"{start} array.array() must have the type code of '{code}'"
            )
            assert not field.size or len(value) <= field.size, (
                f"{start} array.array() must have a size <= {field.size}"
            )
        else:
            assert holds(value), text

    return check
