"""Validation of topic and service names before expansion."""

from typing import Final, Literal

from embedded_ros.names import topic_name_error
from rclpy.exceptions import InvalidServiceNameException, InvalidTopicNameException

TOPIC_SEPARATOR_STRING: Final = "/"


def validate_topic_name(name: str, *, is_service: bool = False) -> Literal[True]:
    """Return True, or raise an exception that points at the fault.

    Parameters
    ----------
    name : str
        May be relative, private (``~/x``) or hold substitutions (``{node}``).
    is_service : bool
        Whether to raise :class:`.InvalidServiceNameException`, not
        :class:`.InvalidTopicNameException`.
    """
    error = topic_name_error(name)
    if error is None:
        return True
    raise (InvalidServiceNameException if is_service else InvalidTopicNameException)(name, *error)
