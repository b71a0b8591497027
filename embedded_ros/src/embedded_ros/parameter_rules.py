"""What a parameter's descriptor lets pass. Results carry rclpy's reasons."""

import math
from collections.abc import Mapping
from typing import Any

from rclpy.parameter import Parameter

__all__ = ["check_descriptor", "reject", "select_names"]

_RELATIVE_TOLERANCE = 1e-6


def accept() -> Any:
    """A positive ``SetParametersResult``."""
    from rcl_interfaces.msg import SetParametersResult

    return SetParametersResult(successful=True)


def reject(reason: str) -> Any:
    """A negative ``SetParametersResult``."""
    from rcl_interfaces.msg import SetParametersResult

    return SetParametersResult(successful=False, reason=reason)


def check_descriptor(
    parameter: Parameter, descriptor: Any, *, is_declared: bool, check_read_only: bool
) -> Any:
    """Check a new value; the descriptor takes the parameter's name and, if dynamic, its type.

    Parameters
    ----------
    parameter : Parameter
    descriptor : rcl_interfaces.msg.ParameterDescriptor
    is_declared : bool
    check_read_only : bool

    Returns
    -------
    rcl_interfaces.msg.SetParametersResult
    """
    name, type_ = parameter.name, parameter.type_
    descriptor.name = name
    if check_read_only and descriptor.read_only:
        return reject(f"Trying to set a read-only parameter: {name}.")
    if descriptor.dynamic_typing:
        descriptor.type = type_.value
    elif is_declared and type_ is Parameter.Type.NOT_SET:
        return reject("Static parameter cannot be undeclared")
    elif type_ is not Parameter.Type.NOT_SET and type_.value != descriptor.type:
        return reject(
            f"Wrong parameter type, expected '{Parameter.Type(descriptor.type)}' got '{type_}'"
        )
    if type_ is Parameter.Type.INTEGER and descriptor.integer_range:
        return _check_integer(name, parameter.value, descriptor.integer_range[0])
    if type_ is Parameter.Type.DOUBLE and descriptor.floating_point_range:
        return _check_double(name, parameter.value, descriptor.floating_point_range[0])
    return accept()


def _check_integer(name: str, value: int, limits: Any) -> Any:
    low = min(limits.from_value, limits.to_value)
    high = max(limits.from_value, limits.to_value)
    if not low <= value <= high:
        return reject(f"Parameter {name} out of range. Min: {low}, Max: {high}, value: {value}")
    # The ends are allowed even off the steps.
    if value not in (low, high) and limits.step and (value - low) % limits.step:
        return reject(
            f"The parameter value for {name} is not a valid step. "
            f"Min: {low}, max: {high}, value: {value}, step: {limits.step}"
        )
    return accept()


def _check_double(name: str, value: float, limits: Any) -> Any:
    low = min(limits.from_value, limits.to_value)
    high = max(limits.from_value, limits.to_value)
    if _is_close(value, low) or _is_close(value, high):
        return accept()
    # Written so that NaN is out of range.
    if not low < value < high:
        return reject(f"Parameter {name} out of range Min: {low}, Max: {high}, value: {value}")
    if limits.step:
        steps = round((value - low) / limits.step)
        if not _is_close(low + steps * limits.step, value):
            return reject(
                f"The parameter value for {name} is not close enough to a valid step. "
                f"Min: {low}, max: {high}, value: {value}, step: {limits.step}"
            )
    return accept()


def _is_close(value: float, other: float) -> bool:
    return math.isclose(value, other, rel_tol=_RELATIVE_TOLERANCE)


def select_names(names: Mapping[str, Any], prefixes: list[str], depth: int) -> list[str]:
    """Names below any of the prefixes, with fewer separators than `depth` (0: any number)."""

    def is_shallow(rest: str) -> bool:
        return rest.count(".") < depth

    def is_wanted(name: str) -> bool:
        if not prefixes and (depth == 0 or is_shallow(name)):
            return True
        return any(
            name == prefix
            or (
                name.startswith(f"{prefix}.")
                and (depth == 0 or is_shallow(name[len(prefix) + 1 :]))
            )
            for prefix in prefixes
        )

    return [name for name in names if is_wanted(name)]
