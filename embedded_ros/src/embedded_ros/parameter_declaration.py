"""What a declaration of a parameter must be; texts are those of rclpy."""

import warnings
from typing import Any

from rclpy.parameter import Parameter
from rclpy.validate_parameter_name import validate_parameter_name

__all__ = ["checked_declaration"]


def checked_declaration(namespace: str, index: int, entry: tuple[Any, ...]) -> tuple[str, Any, Any]:
    """Check an element of the list that ``declare_parameters`` takes.

    Parameters
    ----------
    namespace : str
        Put with a dot before the name, unless it is empty.
    index : int
        Where the element stands.
    entry : tuple
        Name and maybe value and descriptor.

    Returns
    -------
    str
        Full name.
    object
        Default value; None if there is none.
    rcl_interfaces.msg.ParameterDescriptor
        With the type filled in.
    """
    from rcl_interfaces.msg import ParameterDescriptor, ParameterValue

    if not 1 <= len(entry) <= 3:
        raise TypeError(
            f"Invalid parameter tuple length at index {index} in parameters list: "
            f"{entry}; expecting length between 1 and 3"
        )
    name = entry[0]
    if not isinstance(name, str):
        raise TypeError(f"First element {name} at index {index} in parameters list is not a str.")
    name = f"{namespace}.{name}" if namespace else name
    validate_parameter_name(name)
    value = entry[1] if len(entry) > 1 else None
    descriptor = entry[2] if len(entry) > 2 else ParameterDescriptor()
    if not isinstance(descriptor, ParameterDescriptor):
        raise TypeError(
            f"Third element {descriptor} at index {index} in parameters list "
            "is not a ParameterDescriptor."
        )
    if len(entry) == 1:
        warnings.warn(
            f"when declaring parameter named '{name}', "
            "declaring a parameter only providing its name is deprecated. "
            "You have to either:\n"
            '\t- Pass a name and a default value different to "PARAMETER NOT SET"'
            " (and optionally a descriptor).\n"
            "\t- Pass a name and a parameter type.\n"
            "\t- Pass a name and a descriptor with `dynamic_typing=True",
            stacklevel=4,
        )
        descriptor.dynamic_typing = True
    if isinstance(value, Parameter.Type):
        if value is Parameter.Type.NOT_SET:
            raise ValueError(
                f"Cannot declare parameter {{{name}}} as statically typed of type NOT_SET"
            )
        if descriptor.dynamic_typing:
            raise ValueError(
                f"When declaring parameter {{{name}}} passing a descriptor with"
                "`dynamic_typing=True` is not allowed when the parameter type is provided"
            )
        descriptor.type = value.value
        return name, None, descriptor
    if not descriptor.dynamic_typing:
        if isinstance(value, ParameterValue):
            descriptor.type = value.type
        else:
            descriptor.type = Parameter.Type.from_parameter_value(value).value
        if descriptor.type == Parameter.Type.NOT_SET.value:
            raise ValueError(
                "Cannot declare a statically typed parameter with default value "
                "of type PARAMETER_NOT_SET"
            )
    return name, value, descriptor
