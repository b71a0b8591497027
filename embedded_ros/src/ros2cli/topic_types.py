"""The type of a topic, as its users know it."""

import time
from typing import Any

import rclpy
from rclpy.node import Node
from ros2cli.errors import CommandError
from ros2cli.messages import import_type
from ros2cli.node_session import full_topic_name

__all__ = ["message_class_of_topic", "not_published_yet", "type_name_of_topic"]


def not_published_yet(topic: str) -> str:
    """What the user is told about a topic that nobody uses."""
    return f"WARNING: topic [{topic}] does not appear to be published yet"


def type_name_of_topic(node: Node, topic: str, seconds: float) -> str | None:
    """Name of the type of a topic; None if nobody uses it within a time (negative: for ever)."""
    name = full_topic_name(node, topic)
    end = time.monotonic() + seconds
    while rclpy.ok():
        types = dict(node.get_topic_names_and_types()).get(name, [])
        if len(types) > 1:
            raise CommandError(
                f"Cannot echo topic '{topic}', as it contains more than one type: "
                f"[{', '.join(types)}]"
            )
        if types:
            return types[0]
        if seconds >= 0 and end <= time.monotonic():
            break
        rclpy.spin_once(node, timeout_sec=0.02)
    return None


def message_class_of_topic(name: str) -> Any:
    """Class of a message type that a topic has."""
    return import_type(name, "msg", f"The message type '{name}' is invalid")
