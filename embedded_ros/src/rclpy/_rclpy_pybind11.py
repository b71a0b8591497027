"""The names that user code imports from rclpy's C extension: its errors."""

from embedded_ros.errors import (
    InvalidHandle,
    NodeNameNonExistentError,
    RCLError,
    RCLInvalidROSArgsError,
    RMWError,
    UnknownROSArgsError,
    UnsupportedEventTypeError,
)
from embedded_ros.public_names import shown_in

__all__ = [
    "InvalidHandle",
    "NodeNameNonExistentError",
    "RCLError",
    "RCLInvalidROSArgsError",
    "RMWError",
    "UnknownROSArgsError",
    "UnsupportedEventTypeError",
]

shown_in(
    __name__,
    InvalidHandle,
    NodeNameNonExistentError,
    RCLError,
    RCLInvalidROSArgsError,
    RMWError,
    UnknownROSArgsError,
    UnsupportedEventTypeError,
)
