"""Services of nav_msgs, made on first use."""

from typing import Any

from embedded_ros.message_classes import interface, interface_names


def __getattr__(name: str) -> Any:
    return interface(__name__, name)


def __dir__() -> list[str]:
    return interface_names(__name__)
