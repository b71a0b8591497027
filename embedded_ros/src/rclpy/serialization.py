"""Messages to and from CDR."""

from typing import Any

from embedded_ros.cdr import ENCAPSULATION, codec
from rclpy.type_support import check_for_type_support

__all__ = ["deserialize_message", "serialize_message"]


def serialize_message(message: Any) -> bytes:
    """Serialize a message, with the four-byte encapsulation header."""
    message_type = type(message)
    check_for_type_support(message_type)
    buffer = bytearray(ENCAPSULATION)
    codec(message_type._ros_type).write(message, buffer)
    return bytes(buffer)


def deserialize_message(serialized_message: bytes, message_type: type[Any]) -> Any:
    """Make a message of what :func:`serialize_message` gave."""
    check_for_type_support(message_type)
    name: str = message_type._ros_type
    return codec(name).read(bytes(serialized_message), len(ENCAPSULATION))
