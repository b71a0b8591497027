"""``ros2 bag play``: publish the messages of a bag at the pace of their recording."""

import argparse
import re
import time
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import rclpy
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.time import Time
from ros2cli.bag_qos import profile_to_offer
from ros2cli.bag_reading import messages_of, open_bag
from ros2cli.errors import CommandError, Terminated
from ros2cli.messages import import_type
from ros2cli.node_session import command_node, full_topic_name

__all__ = ["play"]

_NANOSECONDS = 1e9
#: Subscriptions that are there find a new publisher within this time.
_DISCOVERY_S = 0.5


def play(arguments: argparse.Namespace) -> None:
    """``bag play``."""
    remappings = tuple(word for rule in arguments.remap for word in ("-r", rule))
    with (
        # As in Jazzy: who stops a player has got what was wanted.
        suppress(KeyboardInterrupt, Terminated),
        open_bag(Path(arguments.bag_path), arguments.storage) as reader,
        command_node(name="rosbag2_player", ros_arguments=remappings) as node,
        closing(_Player(node, reader, arguments)) as player,
    ):
        player.wait(_DISCOVERY_S + arguments.delay)
        player.play_once()
        while arguments.loop and player.publishers and rclpy.ok():
            player.wait(arguments.delay)
            player.play_once()
        player.finish()


class _Player:
    """Publishers for the topics of a bag, and the clock of the bag."""

    def __init__(self, node: Node, reader: Any, arguments: argparse.Namespace) -> None:
        self._node = node
        self._reader = reader
        self._arguments = arguments
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(node)
        self._clock: Publisher | None = None
        self._next_clock = float("inf")
        if arguments.clock is not None:
            from rosgraph_msgs.msg import Clock

            self._clock = node.create_publisher(Clock, "/clock", QoSProfile(depth=1))
        #: By the ids of connections.
        self.publishers = self._make_publishers()

    def _make_publishers(self) -> dict[int, Publisher]:
        publishers: dict[int, Publisher] = {}
        log = self._node.get_logger()
        for connection in self._chosen():
            try:
                message_class = import_type(connection.msgtype, "msg")
            except CommandError as error:
                log.warning(f"'{connection.topic}' is not played: {error}")
                continue
            profile, differed = profile_to_offer(connection.ext.offered_qos_profiles)
            if differed:
                log.warning(
                    f"'{connection.topic}' was published with several QoS profiles: it is played "
                    "with the default one"
                )
            publishers[connection.id] = self._node.create_publisher(
                message_class, connection.topic, profile
            )
        return publishers

    def _chosen(self) -> Iterator[Any]:
        wanted = {full_topic_name(self._node, topic) for topic in self._arguments.topics}
        excluded = {full_topic_name(self._node, topic) for topic in self._arguments.exclude_topics}
        if self._arguments.clock is not None:
            excluded.add("/clock")
        try:
            pattern = re.compile(self._arguments.regex)
            excluded_pattern = re.compile(self._arguments.exclude_regex or "(?!)")
        except re.error as error:
            raise CommandError(f"That is no regular expression: {error}") from None
        for connection in self._reader.connections:
            topic = connection.topic
            if topic in excluded or excluded_pattern.search(topic):
                continue
            if wanted or self._arguments.regex:
                by_pattern = bool(self._arguments.regex and pattern.search(topic))
                if topic not in wanted and not by_pattern:
                    continue
            yield connection

    def play_once(self) -> None:
        """Publish the messages of the bag, each at its time."""
        rate = self._arguments.rate
        start = self._reader.start_time + int(self._arguments.start_offset * _NANOSECONDS)
        length = self._arguments.playback_duration
        stop = start + int(length * _NANOSECONDS) if length >= 0 else None
        connections = [item for item in self._reader.connections if item.id in self.publishers]
        if not connections:
            return
        began = time.monotonic()
        self._next_clock = began if self._clock is not None else float("inf")
        for connection, stamp, payload in messages_of(self._reader, connections, start, stop):
            due = began + (stamp - start) / _NANOSECONDS / rate
            self._publish_clock_until(due, began, start)
            self.wait(due - time.monotonic())
            if not rclpy.ok():
                return
            self.publishers[connection.id].publish(bytes(payload))

    def _publish_clock_until(self, due: float, began: float, start: int) -> None:
        """Tell the time of the bag as often as asked until a wall time."""
        while self._clock is not None and self._next_clock <= due and rclpy.ok():
            self.wait(self._next_clock - time.monotonic())
            bag_time = start + (self._next_clock - began) * self._arguments.rate * _NANOSECONDS
            message = self._clock.msg_type(clock=Time(nanoseconds=int(bag_time)).to_msg())
            self._clock.publish(message)
            self._next_clock += 1.0 / self._arguments.clock

    def wait(self, seconds: float) -> None:
        """Run callbacks for a time; an end of the context ends the wait."""
        end = time.monotonic() + seconds
        while rclpy.ok() and (left := end - time.monotonic()) > 0:
            self._executor.spin_once(timeout_sec=left)

    def finish(self) -> None:
        """See to it that the last messages arrive, if that was asked for."""
        timeout = self._arguments.wait_for_all_acked
        if timeout is None:
            return
        for publisher in self.publishers.values():
            limit = Duration(nanoseconds=timeout * 1_000_000 if timeout else -1)
            if not publisher.wait_for_all_acked(limit):
                self._node.get_logger().error(
                    f"Not everybody had all of {publisher.topic_name} within {timeout} ms"
                )

    def close(self) -> None:
        """End the executor."""
        self._executor.shutdown()
