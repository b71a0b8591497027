"""Message classes with the behavior of rosidl's, made on first use from the definitions."""

import os
import sys
import threading
from array import array
from operator import attrgetter
from typing import Any, ClassVar, Final

import numpy as np

from embedded_ros.definitions import (
    EMPTY_MEMBER,
    Field,
    constants_of,
    fields_of,
    message_names,
    service_names,
)
from embedded_ros.field_checks import ARRAY_CODES, make_check
from embedded_ros.field_values import to_array, to_fixed_array
from embedded_ros.slot_types import slot_type

__all__ = ["CHECK_FIELDS", "interface", "interface_names", "message_class", "ros_type_name"]

#: rosidl checks field types and ranges only on request.
CHECK_FIELDS: Final = os.environ.get("ROS_PYTHON_CHECK_FIELDS", "") == "1"

_IDL_NAMES = {"float64": "double", "float32": "float", "byte": "octet", "bool": "boolean"}
_ZEROS = {"string": "''", "bool": "False", "byte": "b'\\x00'", "float32": "0.0", "float64": "0.0"}

_lock = threading.RLock()
_classes: dict[str, type[Any]] = {}


class _MessageType(type):
    """Keeps the constants of a message class constant."""

    def __setattr__(cls, name: str, value: Any) -> None:
        if name.isupper():
            raise AttributeError(f"{cls.__name__}.{name} is a constant")
        super().__setattr__(name, value)


class MessageBase(metaclass=_MessageType):
    """What the generated classes share: comparison, ``repr`` and the description of fields."""

    __slots__ = ()
    _fields_and_field_types: ClassVar[dict[str, str]] = {}
    SLOT_TYPES: ClassVar[tuple[Any, ...]] = ()
    #: ``package/msg/Name``: how the embedded transport recognizes a message class.
    _ros_type = ""

    @classmethod
    def get_fields_and_field_types(cls) -> dict[str, str]:
        """Names and IDL types of the fields, in order."""
        return dict(cls._fields_and_field_types)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, self.__class__):
            return False
        for name in self._fields_and_field_types:
            different = getattr(self, name) != getattr(other, name)
            # rosidl, too, takes numpy fields for equal unless every element differs.
            if different.all() if isinstance(different, np.ndarray) else different:
                return False
        return True

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        values = []
        for name in self._fields_and_field_types:
            value = getattr(self, name)
            text = repr(value)
            if isinstance(value, array):
                text = text[len("array('d', ") : -1] if len(value) else "[]"
            values.append(f"{name}={text}")
        return f"{self.__class__.__module__}.{self.__class__.__name__}({', '.join(values)})"


def ros_type_name(message_type: Any) -> str | None:
    """``package/msg/Name`` of a message class; None if it is not one."""
    return getattr(message_type, "_ros_type", None) or None


def message_class(type_name: str) -> type[Any]:
    """Class of a message type.

    Parameters
    ----------
    type_name : str
        For example ``std_msgs/msg/Header`` or ``std_srvs/srv/Trigger_Request``.

    Raises
    ------
    KeyError
        If there is no such type.
    """
    try:
        return _classes[type_name]
    except KeyError:
        with _lock:
            if type_name not in _classes:
                _classes[type_name] = _make_class(type_name)
            return _classes[type_name]


def interface(module: str, name: str) -> Any:
    """Look up what ``from <module> import <name>`` asks for.

    Parameters
    ----------
    module : str
        ``std_msgs.msg``, ``std_srvs.srv``, …
    name : str
        Name of a message or service.
    """
    found = interface_names(module) if name == "__all__" else _interface_class(module, name)
    # Found in the module from now on: rclpy imports messages inside functions that run often.
    setattr(sys.modules[module], name, found)
    return found


def _interface_class(module: str, name: str) -> type[Any]:
    package, kind = module.split(".")
    if kind == "msg" and name in message_names(package):
        return message_class(f"{package}/msg/{name}")
    if kind == "srv":
        service, _, part = name.partition("_")
        if service in service_names(package):
            if part in ("Request", "Response"):
                return message_class(f"{package}/srv/{name}")
            if not part:
                return _service_class(f"{package}/srv/{name}")
    raise AttributeError(f"module {module!r} has no attribute {name!r}")


def interface_names(module: str) -> list[str]:
    """Names that a message package's ``msg`` or ``srv`` module offers."""
    package, kind = module.split(".")
    return message_names(package) if kind == "msg" else service_names(package)


def _service_class(name: str) -> type[Any]:
    with _lock:
        if name not in _classes:
            package, _, short = name.split("/")
            _classes[name] = type(
                short,
                (),
                {
                    "__doc__": f"Service {name}.",
                    "__module__": f"{package}.srv",
                    "__init__": _no_instance,
                    "Request": message_class(f"{name}_Request"),
                    "Response": message_class(f"{name}_Response"),
                    "_ros_service": name,
                },
            )
        return _classes[name]


def _no_instance(_self: Any) -> None:
    raise NotImplementedError("Service classes can not be instantiated")


def _idl_type(field: Field) -> str:
    if field.is_message:
        package, _, short = field.type_name.split("/")
        name = f"{package}/{short}"
    else:
        name = _IDL_NAMES.get(field.type_name, field.type_name)
        if field.string_limit:
            name += f"<{field.string_limit}>"
    if field.container == "array":
        return f"{name}[{field.size}]"
    if field.container == "sequence":
        return f"sequence<{name}, {field.size}>" if field.size else f"sequence<{name}>"
    return name


def _make_class(type_name: str) -> type[Any]:
    package, kind, short = type_name.split("/")
    fields = [field for field in fields_of(type_name) if field.name != EMPTY_MEMBER]
    namespace: dict[str, Any] = dict(constants_of(type_name))
    nested: dict[str, Any] = {}
    for field in fields:
        message = message_class(field.type_name) if field.is_message else None
        if message is not None:
            nested[message.__name__] = message
        namespace[field.name] = _property(field, message)
    namespace |= {
        "__doc__": f"Message {type_name}.",
        "__module__": f"{package}.{kind}",
        "__qualname__": short,
        "__slots__": [*(f"_{field.name}" for field in fields), "_check_fields"],
        "__init__": _make_init(short, fields, nested),
        "_fields_and_field_types": {field.name: _idl_type(field) for field in fields},
        "SLOT_TYPES": tuple(slot_type(field) for field in fields),
        "_ros_type": type_name,
    }
    return _MessageType(short, (MessageBase,), namespace)


def _default(field: Field) -> str:
    """Source of the expression that makes the value of a field in a new message."""
    short = field.type_name.rpartition("/")[2]
    if field.container == "sequence":
        code = None if field.is_message else ARRAY_CODES.get(field.type_name)
        return f"array({code!r})" if code else "[]"
    if field.is_message:
        one = f"{short}()"
    elif field.default is not None:
        return repr(field.default)
    else:
        one = _ZEROS.get(field.type_name, "0")
    if field.container == "array":
        code = None if field.is_message else ARRAY_CODES.get(field.type_name)
        return f"zeros({field.size}, {code!r})" if code else f"[{one} for _ in range({field.size})]"
    return one


def _converted(field: Field) -> str:
    """Source of what an argument becomes before its setter checks it, if that is asked for."""
    code = None if field.is_message else ARRAY_CODES.get(field.type_name)
    if code is None or field.container is None:
        return field.name
    if field.container == "sequence":
        return f"_to_array({code!r}, {field.name})"
    return f"_to_fixed_array({code!r}, {field.name}, {field.size})"


def _make_init(class_name: str, fields: list[Field], nested: dict[str, Any]) -> Any:
    # Compiled per class: a loop over the fields would cost several times as much per message.
    arguments = "".join(f"{field.name}=_unset, " for field in fields)
    lines = [
        f"def __init__(self, *, {arguments}check_fields=_check, **_unknown):",
        "    self._check_fields = check_fields",
        "    if check_fields:",
        "        assert not _unknown, 'Invalid arguments passed to constructor: %s' % \\",
        "            ', '.join(sorted(_unknown))",
    ]
    for field in fields:
        lines += [
            f"    if {field.name} is _unset:",
            f"        self._{field.name} = {_default(field)}",
            "    else:",
            f"        self.{field.name} = {_converted(field)}",
        ]
    scope = {"_unset": object(), "_check": CHECK_FIELDS, "array": array, "zeros": np.zeros}
    scope |= {"_to_array": to_array, "_to_fixed_array": to_fixed_array, **nested}
    exec("\n".join(lines), scope)  # noqa: S102 - source made above from type definitions
    init: Any = scope["__init__"]
    init.__qualname__ = f"{class_name}.__init__"
    return init


def _property(field: Field, message: type[Any] | None) -> property:
    slot = f"_{field.name}"
    check = make_check(field, message)
    code = None if field.is_message else ARRAY_CODES.get(field.type_name)

    def set_plain(self: Any, value: Any) -> None:
        if self._check_fields:
            check(value)
        setattr(self, slot, value)

    def set_sequence(self: Any, value: Any) -> None:
        if self._check_fields:
            check(value)
            if isinstance(value, array):
                setattr(self, slot, value)
                return
        setattr(self, slot, to_array(code or "", value))

    def set_array(self: Any, value: Any) -> None:
        if self._check_fields:
            check(value)
            if isinstance(value, np.ndarray):
                setattr(self, slot, value)
                return
        setattr(self, slot, np.array(value, dtype=code))

    setter = set_plain
    if code is not None and field.container is not None:
        setter = set_sequence if field.container == "sequence" else set_array
    return property(attrgetter(slot), setter, doc=f"Message field '{field.name}'.")
