"""Hears a topic for a moment now and then: each of its subscribers holds its publisher up."""

from collections.abc import Callable

from rclpy.node import Node
from rclpy.subscription import Subscription

from bdt_bags.recorder.topic_choice import ChosenTopic

PAUSE = 10.0
"""Wall time [s] between the beginnings of two looks."""

ENOUGH = 50
"""Messages after which a look ends."""


class ShortLooks:
    """Subscribes for some messages, and again a while later.

    Parameters
    ----------
    node : rclpy.node.Node
        Node that listens.
    chosen : ChosenTopic
        What it listens to.
    take : callable
        Takes a serialized message, and what is known of its way.
    """

    def __init__(
        self, node: Node, chosen: ChosenTopic, take: Callable[[bytes, dict[str, int]], None]
    ) -> None:
        self._node, self._chosen, self._take = node, chosen, take
        self._subscription: Subscription | None = None
        self._messages, self._due = 0, 0.0

    def look(self, now: float) -> None:
        """Begin a look if it is time, or end one that has seen enough.

        Parameters
        ----------
        now : float
            Monotonic wall time [s].
        """
        if self._subscription is None:
            if now >= self._due:
                self._messages, self._due = 0, now + PAUSE
                chosen = self._chosen
                self._subscription = self._node.create_subscription(
                    chosen.message_type, chosen.recorded.name, self._note, chosen.profile, raw=True
                )
        elif self._messages >= ENOUGH:
            self._node.destroy_subscription(self._subscription)
            self._subscription = None

    def _note(self, data: bytes, info: dict[str, int]) -> None:
        self._messages += 1
        self._take(data, info)
