"""Validation of node names."""

from typing import Literal

from embedded_ros.names import node_name_error
from rclpy.exceptions import InvalidNodeNameException


def validate_node_name(node_name: str) -> Literal[True]:
    """Return True, or raise :class:`.InvalidNodeNameException`."""
    error = node_name_error(node_name)
    if error is not None:
        raise InvalidNodeNameException(node_name, *error)
    return True
