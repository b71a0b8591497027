"""Messages between the nodes of one process: handed over first, published afterwards.

A message that goes through the network, even to its own process, is serialized, waited for and
read again. Where a machine waits for the answer, the node that gives it is called instead; all
others get the message from its topic when the answer has been given.
"""

from collections.abc import Callable
from typing import Any

from bdt_msgs_py.topics import Topic

Taker = Callable[[Any], object]


class HandOver:
    """Takes messages to callbacks in this process, then to their topics.

    Callbacks that publish in turn hand over, too: what was published first goes to its topic
    first, when the first callback has returned.
    """

    def __init__(self) -> None:
        self._takers: dict[str, Taker] = {}
        self._unpublished: list[tuple[Any, Any]] = []
        self._is_handing = False

    def take(self, topic: Topic, taker: Taker) -> None:
        """Have a callback called with each message of a topic that is published here."""
        self._takers[topic.name] = taker

    def publish(self, topic: Topic, publisher: Any, message: Any) -> None:
        """Hand a message over and publish it.

        Parameters
        ----------
        topic : Topic
            Its topic.
        publisher : rclpy.publisher.Publisher
            Publisher of the topic.
        message : message
            The message.
        """
        self._unpublished.append((publisher, message))
        taker = self._takers.get(topic.name)
        is_first, self._is_handing = not self._is_handing, True
        try:
            if taker is not None:
                taker(message)
        finally:
            if is_first:
                self._is_handing = False
                unpublished, self._unpublished = self._unpublished, []
                for each, given in unpublished:
                    each.publish(given)


class HandingPublisher:
    """Publisher of a topic that is taken in this process, too.

    Parameters
    ----------
    hand_over : HandOver
        Takes the messages.
    topic : Topic
        The topic.
    publisher : rclpy.publisher.Publisher
        Its publisher, which has everything else that a publisher has.
    """

    def __init__(self, hand_over: HandOver, topic: Topic, publisher: Any) -> None:
        self._hand_over, self._topic, self._publisher = hand_over, topic, publisher

    def publish(self, message: Any) -> None:
        """Hand a message over and publish it."""
        self._hand_over.publish(self._topic, self._publisher, message)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._publisher, name)


def handing_node(
    kind: type[Any], hand_over: HandOver, *, gives: Topic, takes: Topic, hears_others: bool
) -> Callable[..., Any]:
    """Return a kind of node that exchanges two topics within its process.

    Parameters
    ----------
    kind : type
        The node as it is where it has a process of its own.
    hand_over : HandOver
        Shared by the nodes.
    gives, takes : Topic
        What it publishes for the other node, and what it takes from that.
    hears_others : bool
        Whether it subscribes to what it takes all the same, and gets it from other processes.
        What comes from this one it gets a second time then.
    """

    class HandingNode(kind):  # type: ignore[misc]
        def create_publisher(self, msg_type: Any, topic: str, *given: Any, **options: Any) -> Any:
            publisher = super().create_publisher(msg_type, topic, *given, **options)
            return (
                HandingPublisher(hand_over, gives, publisher) if topic == gives.name else publisher
            )

        def create_subscription(
            self, msg_type: Any, topic: str, callback: Taker, *given: Any, **options: Any
        ) -> Any:
            if topic == takes.name:
                hand_over.take(takes, callback)
                if not hears_others:
                    return None
            return super().create_subscription(msg_type, topic, callback, *given, **options)

    return HandingNode
