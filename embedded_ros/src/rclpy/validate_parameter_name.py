"""Validation of parameter names."""

from typing import Literal

from rclpy.exceptions import InvalidParameterException


def validate_parameter_name(name: str) -> Literal[True]:
    """Return True, or raise :class:`.InvalidParameterException` if the name is empty."""
    if not name:
        raise InvalidParameterException(name)
    return True
