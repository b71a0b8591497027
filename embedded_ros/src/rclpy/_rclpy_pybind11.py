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

__all__ = [
    "InvalidHandle",
    "NodeNameNonExistentError",
    "RCLError",
    "RCLInvalidROSArgsError",
    "RMWError",
    "UnknownROSArgsError",
    "UnsupportedEventTypeError",
]
