"""What a descriptor lets pass."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

from embedded_ros.parameter_type import ParameterType
from embedded_ros.parameter_value import Parameter

__all__ = ["Objection", "objection"]

#: Relative distance at which a double counts as an end of its range or as one of its steps.
_CLOSENESS: Final = 1e-6


@dataclass(frozen=True)
class Objection:
    """Why a value does not pass.

    Attributes
    ----------
    reason : str
        As the answer to a request has it.
    expected_type : ParameterType, optional
        Given if the value is of another type.
    """

    reason: str
    expected_type: ParameterType | None = None


def objection(
    parameter: Parameter, descriptor: Any, *, is_declared: bool, mind_read_only: bool
) -> Objection | None:
    """Reason why a descriptor does not let a value pass; None if it does.

    Parameters
    ----------
    parameter : Parameter
    descriptor : rcl_interfaces.msg.ParameterDescriptor
    is_declared : bool
        Whether the parameter is there: no value then means to undeclare it.
    mind_read_only : bool
        Whether read-only parameters stay as they are; not so while they are declared.
    """
    if mind_read_only and descriptor.read_only:
        return Objection(f"Trying to set a read-only parameter: {parameter.name}.")
    if not descriptor.dynamic_typing:
        if parameter.type_ is ParameterType.NOT_SET:
            return Objection("Static parameter cannot be undeclared") if is_declared else None
        if parameter.type_.value != descriptor.type:
            expected = ParameterType(descriptor.type)
            return Objection(
                f"Wrong parameter type, expected '{expected}' got '{parameter.type_}'", expected
            )
    text = None
    if parameter.type_ is ParameterType.INTEGER:
        text = _misfit_of_integer(parameter, descriptor.integer_range)
    elif parameter.type_ is ParameterType.DOUBLE:
        text = _misfit_of_double(parameter, descriptor.floating_point_range)
    return None if text is None else Objection(text)


def _ends(limits: Any) -> tuple[Any, Any]:
    first, last = sorted((limits.from_value, limits.to_value))
    return first, last


def _misfit_of_integer(parameter: Parameter, ranges: Any) -> str | None:
    if not ranges:
        return None
    value, step = parameter.value, ranges[0].step
    low, high = _ends(ranges[0])
    if value < low or value > high:
        where = f"Min: {low}, Max: {high}, value: {value}"
        return f"Parameter {parameter.name} out of range. {where}"
    # The upper end is allowed even if no number of steps leads there.
    if step == 0 or value == high or (value - low) % step == 0:
        return None
    grid = f"Min: {low}, max: {high}, value: {value}, step: {step}"
    return f"The parameter value for {parameter.name} is not a valid step. {grid}"


def _misfit_of_double(parameter: Parameter, ranges: Any) -> str | None:
    if not ranges:
        return None
    value, step = parameter.value, ranges[0].step
    low, high = _ends(ranges[0])
    if any(math.isclose(value, end, rel_tol=_CLOSENESS) for end in (low, high)):
        return None
    # NaN is in no range: no comparison holds for it.
    if not (low < value < high):
        where = f"Min: {low}, Max: {high}, value: {value}"
        return f"Parameter {parameter.name} out of range {where}"
    # No value is a step where steps cannot be counted: from an infinite end, or endlessly small.
    steps = (value - low) / step if step else 0.0
    nearest = low + round(steps) * step if math.isfinite(steps) else math.nan
    if step == 0 or math.isclose(nearest, value, rel_tol=_CLOSENESS):
        return None
    grid = f"Min: {low}, max: {high}, value: {value}, step: {step}"
    return f"The parameter value for {parameter.name} is not close enough to a valid step. {grid}"
