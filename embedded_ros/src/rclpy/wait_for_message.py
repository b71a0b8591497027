"""Waiting for one message."""

from __future__ import annotations

import time
from typing import Any

from embedded_ros import cyclone
from rclpy.exceptions import NotInitializedException
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
    received: list[Any] = []
    subscription = node.create_subscription(msg_type, topic, received.append, qos_profile)
    interruption = cyclone.GuardCondition(session.ref)
    waiter = _Waiter(interruption)
    session.register(waiter)
    wait_set = cyclone.WaitSet(session.ref)
    deadline = None if time_to_wait < 0 else time.monotonic() + time_to_wait
    try:
        wait_set.attach(interruption.ref)
        wait_set.attach(subscription._wait_ref)
        while node.context.ok():
            left = cyclone.INFINITE
            if deadline is not None:
                left = max(0, int((deadline - time.monotonic()) * 1e9))
            wait_set.wait(left)
            interruption.clear()
            taken = subscription._take()
            if taken is not None:
                callback, arguments = taken
                callback(*arguments)
                return True, received[0]
            if left == 0:
                break
        return False, None
    finally:
        wait_set.close()
        interruption.close()
        node.destroy_subscription(subscription)


class _Waiter:
    """Ends the wait when the context is shut down."""

    def __init__(self, condition: cyclone.GuardCondition) -> None:
        self._condition = condition

    def interrupt(self) -> None:
        self._condition.set()
