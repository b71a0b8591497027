"""Checks that something is a message or service type."""

from typing import Any

from embedded_ros.message_classes import ros_type_name

__all__ = ["check_for_type_support", "check_is_valid_msg_type", "check_is_valid_srv_type"]


def check_for_type_support(msg_or_srv_type: Any) -> None:
    """Raise ``AttributeError`` if this is no type of ROS."""
    if not ros_type_name(msg_or_srv_type) and not hasattr(msg_or_srv_type, "_ros_service"):
        raise AttributeError(
            f"{msg_or_srv_type!r} has no type support: it is not a class of a ROS 2 interface."
        )


def check_is_valid_msg_type(msg_type: Any) -> None:
    """Raise ``RuntimeError`` if this is a service, ``AttributeError`` if it is no type of ROS."""
    check_for_type_support(msg_type)
    if not ros_type_name(msg_type):
        raise RuntimeError(
            f"The message type provided is not valid ({msg_type}),"
            " this might be a service or action"
        )


def check_is_valid_srv_type(srv_type: Any) -> None:
    """Raise ``RuntimeError`` if this is a message, ``AttributeError`` if it is no type of ROS."""
    check_for_type_support(srv_type)
    if not hasattr(srv_type, "_ros_service"):
        raise RuntimeError(
            f"The service type provided is not valid ({srv_type}),"
            " this might be a message or action"
        )
