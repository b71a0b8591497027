"""Types described by ``type_description_interfaces/msg/TypeDescription``."""

from typing import Any

from embedded_ros.definitions import Field, fields_of, type_hash
from embedded_ros.message_classes import message_class

__all__ = ["describe"]

# Numbers of type_description_interfaces/msg/FieldType.
_TYPE_IDS = {
    "nested": 1,
    "int8": 2,
    "uint8": 3,
    "int16": 4,
    "uint16": 5,
    "int32": 6,
    "uint32": 7,
    "int64": 8,
    "uint64": 9,
    "float32": 10,
    "float64": 11,
    "bool": 15,
    "byte": 16,
    "string": 17,
    "bounded_string": 21,
}
_ARRAY, _BOUNDED_SEQUENCE, _SEQUENCE = 48, 96, 144


def describe(type_name: str) -> tuple[Any, str]:
    """Describe a type and all that it is made of.

    Parameters
    ----------
    type_name : str

    Returns
    -------
    type_description_interfaces.msg.TypeDescription
    str
        RIHS01 hash of the type.
    """
    referenced = _referenced(type_name) - {type_name}
    description = message_class("type_description_interfaces/msg/TypeDescription")(
        type_description=_individual(type_name),
        referenced_type_descriptions=[_individual(name) for name in sorted(referenced)],
    )
    return description, type_hash(type_name)


def _referenced(type_name: str) -> set[str]:
    found = {type_name}
    for field in fields_of(type_name):
        if field.is_message:
            found |= _referenced(field.type_name)
    return found


def _individual(type_name: str) -> Any:
    field_class = message_class("type_description_interfaces/msg/Field")
    return message_class("type_description_interfaces/msg/IndividualTypeDescription")(
        type_name=type_name,
        fields=[
            field_class(name=field.name, type=_field_type(field)) for field in fields_of(type_name)
        ],
    )


def _field_type(field: Field) -> Any:
    name = "bounded_string" if field.string_limit else field.type_name
    number = _TYPE_IDS["nested" if field.is_message else name]
    if field.container == "array":
        number += _ARRAY
    elif field.container == "sequence":
        number += _BOUNDED_SEQUENCE if field.size else _SEQUENCE
    return message_class("type_description_interfaces/msg/FieldType")(
        type_id=number,
        capacity=field.size,
        string_capacity=field.string_limit,
        nested_type_name=field.type_name if field.is_message else "",
    )
