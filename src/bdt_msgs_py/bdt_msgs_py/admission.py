"""What a node says about messages from outside: the same counts and words for every node."""

from collections.abc import Sequence

from rclpy.node import Node

from bdt_msgs_py.clock_agreement import ClockAgreement
from bdt_msgs_py.clock_check import ClockCheck
from bdt_msgs_py.diagnostics import Health
from bdt_msgs_py.rejection import MessageRejectedError, RejectedMessages
from bdt_msgs_py.sole_publisher import SolePublisherCheck
from bdt_msgs_py.topics import Topic


class Admission:
    """Counts what a node rejects, looks for rivals on its topics, and checks times.

    Parameters
    ----------
    node : rclpy.node.Node
        The node.
    sole_publisher : sequence of Topic
        Topics that have one publisher in a healthy loop.
    """

    def __init__(self, node: Node, sole_publisher: Sequence[Topic] = ()) -> None:
        self._rejected = RejectedMessages(node.get_logger())
        self._publishers = SolePublisherCheck(node, sole_publisher)
        self._clock = ClockCheck(node, self._rejected)
        self._agreement = ClockAgreement(node)
        self._reported = 0

    def note_time(self, stamp: int) -> None:
        """Note the stamp [ns] of an accepted message, which has to go with the node's clock."""
        self._agreement.note(stamp)

    def reject(self, topic: Topic, error: MessageRejectedError) -> None:
        """Count a message of `topic` that is not obeyed."""
        self._rejected.count(topic, error)

    @property
    def rejected(self) -> int:
        """Number of messages that were not obeyed."""
        return self._rejected.total

    def complete(self, health: Health) -> Health:
        """Return the health of a node with what there is to say of messages from outside.

        Parameters
        ----------
        health : Health
            All else that the node says of itself.
        """
        texts = [] if health.ok else [health.summary]
        if self._rejected.total > self._reported:
            texts.append("messages rejected")
        self._reported = self._rejected.total
        if fault := self._agreement.fault():
            texts.append(fault)
        contested = self._publishers.contested()
        if contested:
            texts.append(f"more than one publisher of {', '.join(contested)}")
        rivals = "; ".join(f"{name}: {', '.join(nodes)}" for name, nodes in contested.items())
        values = {
            **health.values,
            **self._rejected.values(),
            "topics_with_several_publishers": rivals,
        }
        return Health(
            not texts, "; ".join(texts) or health.summary, values, is_error=health.is_error
        )
