"""Validation of parameter names."""

from typing import Literal

from embedded_ros.errors import InvalidParameterException


def validate_parameter_name(name: str) -> Literal[True]:
    """Return True, or raise :class:`.InvalidParameterException`: any text but '' is a name."""
    if name:
        return True
    raise InvalidParameterException(name)
