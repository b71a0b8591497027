"""Which topics a recorder takes: those of the project, or any that it is told by name."""

from importlib import import_module
from typing import Any, NamedTuple

from rclpy.exceptions import InvalidTopicNameException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.validate_topic_name import validate_topic_name

from bdt_bags.recorder.offered_qos import offered_qos_text
from bdt_bags.writing.topic_metadata import TopicMetadata, topic_metadata
from bdt_msgs_py.node_parameters import ConfigurationError
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.topics import ALL_TOPICS, Topic

HISTORY = 10_000
"""Messages a subscription may hold back while the recorder is busy."""


class ChosenTopic(NamedTuple):
    """A topic to be recorded.

    Attributes
    ----------
    recorded : TopicMetadata
        What the bag says of it.
    message_type : type
        Message class.
    profile : rclpy.qos.QoSProfile
        For the subscription.
    topic : Topic or None
        The topic of the public interface; None for one that is not the project's.
    """

    recorded: TopicMetadata
    message_type: type[Any]
    profile: QoSProfile
    topic: Topic | None


def project_topics(node: Node, names: str) -> tuple[list[ChosenTopic], list[str]]:
    """Return the topics of the public interface that are chosen, and full names of others.

    Parameters
    ----------
    node : rclpy.node.Node
        Its namespace and remap rules hold.
    names : str
        Names with spaces between them; "" for all topics of the public interface.

    Raises
    ------
    ConfigurationError
        For a name that cannot be a topic's.
    """
    known = {node.resolve_topic_name(topic.name): topic for topic in ALL_TOPICS}
    try:
        for name in names.split():
            validate_topic_name(name)
    except InvalidTopicNameException as error:
        raise ConfigurationError(f"parameter topics = {names!r}: {error}") from error
    resolved = [node.resolve_topic_name(name) for name in names.split()]
    wanted = list(dict.fromkeys(resolved or known))
    chosen = [_project_topic(name, known[name]) for name in wanted if name in known]
    return chosen, [name for name in wanted if name not in known]


def published_topic(node: Node, name: str) -> ChosenTopic | None:
    """Return a topic as its publishers offer it; None while there are none.

    Parameters
    ----------
    node : rclpy.node.Node
        Sees the graph.
    name : str
        Full topic name.

    Raises
    ------
    ValueError
        If the type is not one of Jazzy's common interfaces, or not installed.
    """
    publishers = node.get_publishers_info_by_topic(name)
    if not publishers:
        return None
    message_type = publishers[0].topic_type
    offered = [publisher.qos_profile for publisher in publishers]
    # A subscription that asks for no more than everyone offers hears everyone.
    reliable = all(one.reliability == ReliabilityPolicy.RELIABLE for one in offered)
    transient = all(one.durability == DurabilityPolicy.TRANSIENT_LOCAL for one in offered)
    profile = QoSProfile(
        depth=HISTORY,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if transient else DurabilityPolicy.VOLATILE,
    )
    recorded = topic_metadata(name, message_type, offered_qos_text(offered))
    try:
        message_class = _message_class(message_type)
    except (ImportError, AttributeError) as error:
        raise ValueError(f"topic {name} of type {message_type}: {error}") from error
    return ChosenTopic(recorded, message_class, profile, None)


def _project_topic(name: str, topic: Topic) -> ChosenTopic:
    offered = offered_qos_text([qos_profile(topic)])
    return ChosenTopic(
        topic_metadata(name, topic.message_type, offered),
        _message_class(topic.message_type),
        qos_profile(topic, depth=HISTORY),
        topic,
    )


def _message_class(message_type: str) -> type[Any]:
    package, _, name = message_type.split("/")
    found: type[Any] = getattr(import_module(f"{package}.msg"), name)
    return found
