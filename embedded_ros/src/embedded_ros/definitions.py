"""Interface definitions: what the fields of a ROS type are, and its RIHS01 hash.

Messages come from the Jazzy type store of ``rosbags``; services from
:mod:`embedded_ros.service_definitions`. A type is named ``package/msg/Name`` or
``package/srv/Name_Request``.
"""

from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from embedded_ros.service_definitions import SERVICE_DEFINITIONS

__all__ = [
    "EMPTY_MEMBER",
    "Field",
    "constants_of",
    "fields_of",
    "message_names",
    "service_names",
    "type_hash",
]

#: The member that IDL puts into a message without fields; on the wire, not in the Python class.
EMPTY_MEMBER = "structure_needs_at_least_one_member"

#: rosbags' parser does not know default values of fields: they stand here.
_FIELD_DEFAULTS = {
    ("type_description_interfaces/srv/GetTypeDescription_Request", "include_type_sources"): True,
    ("geometry_msgs/msg/Quaternion", "w"): 1.0,
    ("sensor_msgs/msg/NavSatStatus", "status"): -2,
}


@dataclass(frozen=True)
class Field:
    """One field of a message.

    Attributes
    ----------
    name : str
    type_name : str
        A primitive (``float64``, ``string``, …) or the name of a message type.
    is_message : bool
    container : {None, 'array', 'sequence'}
        ``array`` has the fixed length `size`, ``sequence`` at most `size` elements (0: any).
    size : int
    string_limit : int
        Longest string (0: any).
    default : bool, float or None
        Value in a new message where it is not the zero of the type.
    """

    name: str
    type_name: str
    is_message: bool
    container: Literal[None, "array", "sequence"]
    size: int
    string_limit: int
    default: bool | float | None = None


@cache
def _store() -> Typestore:
    store = get_typestore(Stores.ROS2_JAZZY)
    for service, text in SERVICE_DEFINITIONS.items():
        package, _, name = service.split("/")
        # A field default would be read as a part of the name.
        parts = f"\n{text}".replace(" true\n", "\n").split("\n---\n")
        for part, suffix in zip(parts, ("_Request", "_Response"), strict=True):
            # The parser files everything under "msg": parse there, register under "srv".
            (parsed,) = get_types_from_msg(part, f"{package}/msg/{name}{suffix}").values()
            store.register({service + suffix: parsed})
    for name, (constants, fields) in store.fielddefs.items():
        # rosbags keeps "char" apart; in ROS 2 it is another word for uint8, and hashed as that.
        if "'char'" in repr(fields):
            store.fielddefs[name] = (constants, [(n, _without_char(d)) for n, d in fields])
    return store


def _without_char(description: Any) -> Any:
    if isinstance(description, tuple):
        return tuple(_without_char(part) for part in description)
    return "uint8" if description == "char" else description


@cache
def fields_of(type_name: str) -> tuple[Field, ...]:
    """Fields of a message type in wire order.

    Parameters
    ----------
    type_name : str
        For example ``sensor_msgs/msg/JointState``.

    Raises
    ------
    KeyError
        If there is no such type.
    """
    fields = []
    definitions: Any = _store().fielddefs[type_name][1]
    for name, description in definitions:
        container: Literal["array", "sequence"] | None = None
        size = 0
        kind, detail = description
        if kind in (Nodetype.ARRAY, Nodetype.SEQUENCE):
            container = "array" if kind == Nodetype.ARRAY else "sequence"
            (kind, detail), size = detail
        is_message = kind == Nodetype.NAME
        base, limit = (str(detail), 0) if is_message else (str(detail[0]), int(detail[1]))
        default = _FIELD_DEFAULTS.get((type_name, name))
        fields.append(Field(name, base, is_message, container, size, limit, default))
    return tuple(fields)


@cache
def constants_of(type_name: str) -> dict[str, bool | int | float | str | bytes]:
    """Constants of a message type; those of IDL type ``byte`` are ``bytes`` as in rosidl."""
    definitions: Any = _store().fielddefs[type_name][0]
    return {name: bytes([value]) if base == "byte" else value for name, base, value in definitions}


@cache
def type_hash(type_name: str) -> str:
    """RIHS01 hash of a message type, ``RIHS01_`` and 64 hexadecimal digits."""
    return str(_store().hash_rihs01(type_name))


def message_names(package: str) -> list[str]:
    """Names of the messages in a package, sorted."""
    prefix = f"{package}/msg/"
    names = _store().fielddefs
    return sorted(name.removeprefix(prefix) for name in names if name.startswith(prefix))


def service_names(package: str) -> list[str]:
    """Names of the services in a package, sorted."""
    prefix = f"{package}/srv/"
    names = SERVICE_DEFINITIONS
    return sorted(name.removeprefix(prefix) for name in names if name.startswith(prefix))
