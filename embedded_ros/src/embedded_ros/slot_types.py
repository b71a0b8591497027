"""Descriptions of field types in ``SLOT_TYPES``, with the attributes of ``rosidl_parser``'s."""

from dataclasses import dataclass

from embedded_ros.definitions import Field

__all__ = ["slot_type"]

_IDL_NAMES = {"bool": "boolean", "byte": "octet", "float32": "float", "float64": "double"}


@dataclass(frozen=True)
class BasicType:
    """A number, boolean or octet, under its IDL name."""

    typename: str


class UnboundedString:
    """A string of any length."""

    def has_maximum_size(self) -> bool:
        """Tell whether the length is limited."""
        return False


@dataclass(frozen=True)
class BoundedString:
    """A string of limited length."""

    maximum_size: int

    def has_maximum_size(self) -> bool:
        """Tell whether the length is limited."""
        return True


@dataclass
class NamespacedType:
    """A message, by the parts of its name."""

    namespaces: list[str]
    name: str

    def namespaced_name(self) -> tuple[str, ...]:
        """All parts of the name."""
        return (*self.namespaces, self.name)


ElementType = BasicType | UnboundedString | BoundedString | NamespacedType


@dataclass(frozen=True)
class Array:
    """A fixed number of elements."""

    value_type: ElementType
    size: int

    def has_maximum_size(self) -> bool:
        """Tell whether the length is limited."""
        return True


@dataclass(frozen=True)
class UnboundedSequence:
    """Any number of elements."""

    value_type: ElementType

    def has_maximum_size(self) -> bool:
        """Tell whether the length is limited."""
        return False


@dataclass(frozen=True)
class BoundedSequence:
    """At most so many elements."""

    value_type: ElementType
    maximum_size: int

    def has_maximum_size(self) -> bool:
        """Tell whether the length is limited."""
        return True


def slot_type(field: Field) -> ElementType | Array | UnboundedSequence | BoundedSequence:
    """Describe the type of a field."""
    element = _element_type(field)
    if field.container == "array":
        return Array(element, field.size)
    if field.container == "sequence":
        return BoundedSequence(element, field.size) if field.size else UnboundedSequence(element)
    return element


def _element_type(field: Field) -> ElementType:
    if field.is_message:
        *namespaces, name = field.type_name.split("/")
        return NamespacedType(namespaces, name)
    if field.type_name == "string":
        return BoundedString(field.string_limit) if field.string_limit else UnboundedString()
    return BasicType(_IDL_NAMES.get(field.type_name, field.type_name))
