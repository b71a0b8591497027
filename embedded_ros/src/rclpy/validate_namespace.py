"""Validation of namespaces."""

from typing import Literal

from embedded_ros.names import namespace_error
from rclpy.exceptions import InvalidNamespaceException


def validate_namespace(namespace: str) -> Literal[True]:
    """Return True, or raise :class:`.InvalidNamespaceException`."""
    error = namespace_error(namespace)
    if error is not None:
        raise InvalidNamespaceException(namespace, *error)
    return True
