"""Validation of expanded topic and service names."""

from typing import Literal

from embedded_ros.names import full_topic_name_error
from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException


def validate_full_topic_name(name: str, *, is_service: bool = False) -> Literal[True]:
    """Return True, or raise an exception that points at the fault.

    Parameters
    ----------
    name : str
        Absolute, without substitutions.
    is_service : bool
        Whether to raise :class:`.InvalidServiceNameException`, not
        :class:`.InvalidTopicNameException`.
    """
    error = full_topic_name_error(name)
    if error is None:
        return True
    raise (InvalidServiceNameException if is_service else InvalidTopicNameException)(name, *error)
