"""Waiting for one message."""

from typing import Any

from embedded_ros.deadline import Deadline
from embedded_ros.errors import NotInitializedException
from embedded_ros.short_wait import ShortWait
from rclpy.node import Node
from rclpy.qos import QoSProfile

__all__ = ["wait_for_message"]


def wait_for_message(
    msg_type: type[Any],
    node: Node,
    topic: str,
    *,
    qos_profile: QoSProfile | int = 1,
    time_to_wait: float = -1,
) -> tuple[bool, Any]:
    """Wait for the next message of a topic, without an executor.

    Parameters
    ----------
    msg_type : message class
    node : Node
        Makes the subscription. No executor that spins it must take the message.
    topic : str
    qos_profile : QoSProfile or int
    time_to_wait : float
        Seconds; negative: for ever.

    Returns
    -------
    bool
        Whether a message came; not if the context was shut down.
    message or None
    """
    session = node.context.handle
    if session is None:
        raise NotInitializedException
    deadline = Deadline(time_to_wait)
    received: list[Any] = []
    subscription = node.create_subscription(msg_type, topic, received.append, qos_profile)
    try:
        with ShortWait(session, [subscription._wait_ref]) as waiting:
            is_last_look = False
            while node.context.ok() and not is_last_look:
                left = deadline.nanoseconds_left()
                is_last_look = left <= 0
                waiting.wait(left)
                call = subscription._take()
                if call is not None:
                    callback, arguments = call
                    callback(*arguments)
                    return True, received[0]
    finally:
        node.destroy_subscription(subscription)
    return False, None
