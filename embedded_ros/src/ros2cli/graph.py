"""The nodes, topics and services that others have, as a command's own node sees them."""

from collections.abc import Iterable
from dataclasses import dataclass

from rclpy.node import Node
from rclpy.topic_endpoint_info import TopicEndpointInfo
from ros2cli.node_session import wait_until

__all__ = ["Topic", "is_hidden", "node_names", "others", "print_names", "services", "topics"]

#: How long names may be on their way: rmw_fastrtps tells them with a heartbeat, every 3 s.
_NAMES_S = 4.0
_NAMELESS = {"_CREATED_BY_BARE_DDS_APP_", "_NODE_NAME_UNKNOWN_"}


@dataclass(frozen=True)
class Topic:
    """A topic and who uses it."""

    name: str
    types: list[str]
    publishers: list[TopicEndpointInfo]
    subscriptions: list[TopicEndpointInfo]


def is_hidden(name: str) -> bool:
    """Whether a name is meant for tools: one of its parts begins with an underscore."""
    return "/_" in f"/{name}"


def node_names(node: Node) -> list[str]:
    """Full names of the other nodes, sorted, once all that are seen have told theirs."""

    def told() -> bool:
        # Each node of ROS has a publisher here.
        known = node.get_publishers_info_by_topic("/parameter_events")
        return _NAMELESS.isdisjoint(info.node_name for info in known)

    wait_until(node, told, _NAMES_S)
    own = node.get_fully_qualified_name()
    return sorted(name for name in node.get_fully_qualified_node_names() if name != own)


def others(node: Node, endpoints: Iterable[TopicEndpointInfo]) -> list[TopicEndpointInfo]:
    """Endpoints that are not the command's own."""
    return [endpoint for endpoint in endpoints if endpoint.node_name != node.get_name()]


def topics(node: Node, *, hidden: bool) -> list[Topic]:
    """Topics that somebody else uses."""
    every = (
        Topic(
            name,
            types,
            others(node, node.get_publishers_info_by_topic(name)),
            others(node, node.get_subscriptions_info_by_topic(name)),
        )
        for name, types in node.get_topic_names_and_types()
        if hidden or not is_hidden(name)
    )
    return [topic for topic in every if topic.publishers or topic.subscriptions]


def services(node: Node, *, hidden: bool) -> list[tuple[str, list[str]]]:
    """Names and types of the services that somebody else has."""
    own = f"{node.get_fully_qualified_name()}/"
    return [
        (name, types)
        for name, types in node.get_service_names_and_types()
        if not name.startswith(own) and (hidden or not is_hidden(name))
    ]


def print_names(
    items: Iterable[tuple[str, list[str]]], *, types: bool = False, count: bool = False
) -> None:
    """Print names a line each, with their types if wanted; or only how many they are."""
    lines = [f"{name} [{', '.join(kinds)}]" if types else name for name, kinds in items]
    if count:
        lines = [str(len(lines))]
    for line in lines:
        print(line)
