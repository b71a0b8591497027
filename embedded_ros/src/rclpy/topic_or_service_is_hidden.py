"""Hidden names."""

from typing import Final

from rclpy.validate_topic_name import TOPIC_SEPARATOR_STRING

HIDDEN_TOPIC_PREFIX: Final = "_"


def topic_or_service_is_hidden(name: str) -> bool:
    """Tell whether a part of a name begins with an underscore."""
    return any(
        part.startswith(HIDDEN_TOPIC_PREFIX) for part in name.split(TOPIC_SEPARATOR_STRING) if part
    )
