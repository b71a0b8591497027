"""What a recorder subscribes to, and how messages get from subscriptions into a bag."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo
from ros2cli.bag_qos import offered_by, profile_to_request
from ros2cli.errors import CommandError
from ros2cli.graph import is_hidden, others
from ros2cli.interface_texts import definition_with_dependencies
from ros2cli.messages import import_type

__all__ = ["Recorder", "Selection"]


@dataclass(frozen=True)
class Selection:
    """Which topics are recorded.

    Attributes
    ----------
    topics, types : frozenset of str
        Names that are recorded.
    all_topics : bool
    pattern : str
        Regular expression that the name of a recorded topic holds.
    excluded : frozenset of str
    excluded_pattern : str
    hidden, unpublished : bool
        Whether topics with hidden names and without a publisher count.
    """

    topics: frozenset[str]
    types: frozenset[str]
    all_topics: bool
    pattern: str
    excluded: frozenset[str]
    excluded_pattern: str
    hidden: bool
    unpublished: bool

    def wants(self, topic: str, type_name: str) -> bool:
        """Whether a topic is recorded."""
        named = topic in self.topics
        if topic in self.excluded or (
            self.excluded_pattern and re.search(self.excluded_pattern, topic)
        ):
            return False
        if is_hidden(topic) and not self.hidden and not named:
            return False
        return (
            named
            or self.all_topics
            or type_name in self.types
            or bool(self.pattern and re.search(self.pattern, topic))
        )


class Recorder:
    """Subscribes to topics as they appear, and writes their messages as they come.

    Parameters
    ----------
    node : Node
    writer : rosbags.rosbag2.Writer
        Open for writing.
    selection : Selection
    """

    def __init__(self, node: Node, writer: Any, selection: Selection) -> None:
        self.node = node
        self.message_count = 0
        self._writer = writer
        self._selection = selection
        self._profiles: dict[str, QoSProfile] = {}
        self._warned: set[str] = set()

    def look_for_topics(self) -> None:
        """Subscribe to the topics that are new."""
        for topic, types in self.node.get_topic_names_and_types():
            if not self._selection.wants(topic, types[0]):
                continue
            publishers = others(self.node, self.node.get_publishers_info_by_topic(topic))
            if topic in self._profiles:
                self._check_new_publishers(topic, publishers)
            elif publishers or self._selection.unpublished:
                self._subscribe(topic, types, publishers)

    def _subscribe(self, topic: str, types: list[str], publishers: list[TopicEndpointInfo]) -> None:
        if len(types) > 1:
            self._warn_once(
                topic, f"'{topic}' is not recorded: it has several types, {', '.join(types)}"
            )
            return
        type_name = types[0]
        try:
            message_class = import_type(type_name, "msg")
            definition = definition_with_dependencies(type_name)
        except CommandError as error:
            self._warn_once(topic, f"'{topic}' is not recorded: {error}")
            return
        profile, losses = profile_to_request(publishers)
        log = self.node.get_logger()
        for lost in losses:
            log.warning(f"{topic} {lost}")
        connection = self._writer.add_connection(
            topic,
            type_name,
            msgdef=definition,
            rihs01=_type_hash(type_name, publishers),
            offered_qos_profiles=offered_by(publishers),
        )
        self._profiles[topic] = profile
        self.node.create_subscription(
            message_class, topic, self._writing_to(connection), profile, raw=True
        )
        log.info(f"Subscribed to topic '{topic}'")

    def _writing_to(self, connection: Any) -> Callable[[bytes], None]:
        clock = self.node.get_clock()

        def write(payload: bytes) -> None:
            # The time of arrival: what a publisher kept was sent long before the recording.
            now = clock.now().nanoseconds
            if now:  # with simulated time, nothing counts before the first /clock
                self._writer.write(connection, now, payload)
                self.message_count += 1

        return write

    def _check_new_publishers(self, topic: str, publishers: list[TopicEndpointInfo]) -> None:
        """Warn of publishers that came later and offer less than the subscription asks for."""
        profile = self._profiles[topic]
        for info in publishers:
            offered = info.qos_profile
            for lost, offer, request in (
                (
                    profile.reliability == ReliabilityPolicy.RELIABLE
                    and offered.reliability == ReliabilityPolicy.BEST_EFFORT,
                    "BEST_EFFORT",
                    "RELIABLE",
                ),
                (
                    profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
                    and offered.durability == DurabilityPolicy.VOLATILE,
                    "VOLATILE",
                    "TRANSIENT_LOCAL",
                ),
            ):
                if lost:
                    self._warn_once(
                        f"{topic} {offer}",
                        f"A new publisher of '{topic}' is not recorded: it offers {offer}, and "
                        f"the subscription asks for {request} since its beginning",
                    )

    def _warn_once(self, subject: str, text: str) -> None:
        if subject not in self._warned:
            self._warned.add(subject)
            self.node.get_logger().warning(text)


def _type_hash(type_name: str, publishers: list[TopicEndpointInfo]) -> str:
    """Hash that the publishers tell; that of rosbags' definition where none does."""
    for info in publishers:
        text = str(info.topic_type_hash)
        if text != "INVALID":
            return text
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    return store.hash_rihs01(type_name) if type_name in store.fielddefs else "INVALID"
