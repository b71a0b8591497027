"""Topics that one node alone should publish: who else does is told, once and in the diagnostics."""

from collections.abc import Sequence

from rclpy.node import Node

from bdt_msgs_py.topics import Topic


def publisher_count(node: Node, topic: Topic) -> int:
    """Return how many publish a topic, by the name that the remap rules of a node give it.

    Counting by itself takes no notice of these rules.
    """
    return node.count_publishers(node.resolve_topic_name(topic.name))


class SolePublisherCheck:
    """Looks for more than one publisher of topics that should have one.

    Parameters
    ----------
    node : rclpy.node.Node
        Node that publishes or takes the topics.
    topics : sequence of Topic
        The topics.
    """

    def __init__(self, node: Node, topics: Sequence[Topic]) -> None:
        self._node, self._topics = node, topics
        self._told: dict[str, list[str]] = {}

    def contested(self) -> dict[str, list[str]]:
        """Return the full names of the nodes that publish each topic with more than one of them.

        What has not been told yet is logged.
        """
        found = {}
        for topic in self._topics:
            # To count them takes a fifth of the time that it takes to learn who they are.
            if publisher_count(self._node, topic) <= 1:
                continue
            publishers = self._node.get_publishers_info_by_topic(topic.name)
            if len(publishers) > 1:
                found[topic.name] = sorted(
                    f"{one.node_namespace.rstrip('/')}/{one.node_name}" for one in publishers
                )
        for name, nodes in found.items():
            if self._told.get(name) != nodes:
                self._node.get_logger().warning(
                    f"{name} has {len(nodes)} publishers, must have one: {', '.join(nodes)}"
                )
        self._told = found
        return found
