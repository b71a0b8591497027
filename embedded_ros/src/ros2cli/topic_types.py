"""The type of a topic, as its users know it."""

import math
from typing import Any

from rclpy.node import Node
from ros2cli.errors import CommandError, did_you_mean
from ros2cli.messages import import_type
from ros2cli.node_session import full_topic_name, wait_until

__all__ = ["class_of_topic"]


def class_of_topic(node: Node, topic: str, seconds: float, *, patient: bool = False) -> Any:
    """Message class of a topic.

    Parameters
    ----------
    node : Node
    topic : str
        As it was typed.
    seconds : float
        How long somebody may take to use it, before that is told.
    patient : bool
        Whether to go on waiting then.

    Raises
    ------
    CommandError
        If nobody uses it, if users do not agree on its type, or if that is not installed.
    """
    name = full_topic_name(node, topic)

    def known() -> list[str]:
        return dict(node.get_topic_names_and_types()).get(name, [])

    if not wait_until(node, known, seconds):
        print(f"WARNING: topic [{topic}] does not appear to be published yet", flush=True)
        if not patient or not wait_until(node, known, math.inf):
            near = did_you_mean(name, dict(node.get_topic_names_and_types()))
            raise CommandError(f"Nobody uses '{topic}', which would tell its type{near}")
    single, *more = known()
    if more:
        raise CommandError(f"'{topic}' has several types: {', '.join([single, *more])}")
    return import_type(single, "msg")
