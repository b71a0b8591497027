"""``ros2 topic``: topics and their messages."""

import argparse
import statistics
import time
from itertools import pairwise
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros2cli.errors import CommandError
from ros2cli.messages import fill, import_type, parse_values, to_yaml
from ros2cli.node_session import add_spin_time, command_node, is_hidden

__all__ = ["add_commands"]

_PUBLISH_WAIT_S = 1.0


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    group = groups.add_parser("topic", help="Various topic related sub-commands")
    verbs = group.add_subparsers(title="Commands", required=True)
    verb = verbs.add_parser("list", help="Output a list of available topics")
    verb.add_argument("-t", "--show-types", action="store_true", help="Additionally show the type")
    add_spin_time(verb)
    verb.set_defaults(main=_list)
    verb = verbs.add_parser("info", help="Print information about a topic")
    verb.add_argument("topic_name")
    verb.add_argument("-v", "--verbose", action="store_true", help="Print nodes, QoS and hashes")
    add_spin_time(verb)
    verb.set_defaults(main=_info)
    verb = verbs.add_parser("echo", help="Output messages from a topic")
    verb.add_argument("topic_name")
    verb.add_argument("message_type", nargs="?", help="Found out if a publisher is there")
    verb.add_argument("--once", action="store_true", help="Print the first message and exit")
    add_spin_time(verb)
    verb.set_defaults(main=_echo)
    verb = verbs.add_parser("hz", help="Print the average publishing rate to screen")
    verb.add_argument("topic_name")
    verb.add_argument("-w", "--window", type=int, default=10000, help="Messages to average over")
    add_spin_time(verb)
    verb.set_defaults(main=_hz)
    verb = verbs.add_parser("pub", help="Publish a message to a topic")
    verb.add_argument("topic_name")
    verb.add_argument("message_type")
    verb.add_argument("values", nargs="?", default="{}", help="Values of the fields, in YAML")
    verb.add_argument("-r", "--rate", type=float, default=1.0, help="Rate in hertz")
    verb.add_argument("-1", "--once", action="store_true", help="Publish one message and exit")
    verb.set_defaults(main=_pub)


def _list(arguments: argparse.Namespace) -> None:
    with command_node(arguments.spin_time) as node:
        topics = [item for item in node.get_topic_names_and_types() if not is_hidden(item[0])]
        own = node.get_name()
        for name, types in topics:
            # A topic that only this command has made is not there.
            endpoints = node.get_publishers_info_by_topic(name)
            endpoints += node.get_subscriptions_info_by_topic(name)
            if any(endpoint.node_name != own for endpoint in endpoints):
                print(f"{name} [{', '.join(types)}]" if arguments.show_types else name)


def _info(arguments: argparse.Namespace) -> None:
    with command_node(arguments.spin_time) as node:
        name = node.resolve_topic_name(arguments.topic_name)
        types = dict(node.get_topic_names_and_types()).get(name)
        if types is None:
            raise CommandError(f"Unknown topic '{arguments.topic_name}'")
        print("Type:", types[0] if len(types) == 1 else types)
        if arguments.verbose:
            print()
        for title, infos in (
            ("Publisher", node.get_publishers_info_by_topic(name)),
            ("Subscription", node.get_subscriptions_info_by_topic(name)),
        ):
            print(f"{title} count: {len(infos)}")
            if arguments.verbose:
                print()
                for info in infos:
                    print(f"{info}\n")


def _type_of(node: Node, topic: str, spin_time: float) -> str:
    """Type of a topic, once somebody uses it."""
    name = node.resolve_topic_name(topic)
    end = time.monotonic() + spin_time
    while rclpy.ok():
        types = dict(node.get_topic_names_and_types()).get(name)
        if types:
            return types[0]
        if time.monotonic() > end:
            break
        rclpy.spin_once(node, timeout_sec=0.02)
    raise CommandError(f"WARNING: topic [{topic}] does not appear to be published yet")


def _profile(node: Node, topic: str) -> QoSProfile:
    """Profile that all present publishers of a topic satisfy."""
    profile = QoSProfile(depth=10)
    infos = node.get_publishers_info_by_topic(topic)
    offered = [info.qos_profile for info in infos]
    if any(qos.reliability == ReliabilityPolicy.BEST_EFFORT for qos in offered):
        profile.reliability = ReliabilityPolicy.BEST_EFFORT
    if offered and all(qos.durability == DurabilityPolicy.TRANSIENT_LOCAL for qos in offered):
        profile.durability = DurabilityPolicy.TRANSIENT_LOCAL
    return profile


def _echo(arguments: argparse.Namespace) -> None:
    with command_node() as node:
        topic = arguments.topic_name
        type_name = arguments.message_type or _type_of(node, topic, arguments.spin_time)
        printed = 0

        def show(message: Any) -> None:
            nonlocal printed
            if not (arguments.once and printed):
                print(f"{to_yaml(message)}---", flush=True)
            printed += 1

        node.create_subscription(import_type(type_name), topic, show, _profile(node, topic))
        while rclpy.ok() and not (arguments.once and printed):
            rclpy.spin_once(node)


def _hz(arguments: argparse.Namespace) -> None:
    with command_node() as node:
        topic = arguments.topic_name
        type_name = _type_of(node, topic, arguments.spin_time)
        arrivals: list[float] = []
        node.create_subscription(
            import_type(type_name),
            topic,
            lambda _: arrivals.append(time.monotonic()),
            _profile(node, topic),
            raw=True,
        )
        shown = time.monotonic()
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=0.2)
            del arrivals[: -arguments.window - 1]
            if time.monotonic() - shown >= 1.0 and len(arrivals) > 1:
                shown = time.monotonic()
                gaps = [later - earlier for earlier, later in pairwise(arrivals)]
                print(f"average rate: {1.0 / statistics.fmean(gaps):.3f}")
                print(
                    f"\tmin: {min(gaps):.3f}s max: {max(gaps):.3f}s "
                    f"std dev: {statistics.pstdev(gaps):.5f}s window: {len(arrivals)}",
                    flush=True,
                )


def _pub(arguments: argparse.Namespace) -> None:
    with command_node() as node:
        message = fill(import_type(arguments.message_type)(), parse_values(arguments.values))
        publisher = node.create_publisher(type(message), arguments.topic_name, 10)
        end = time.monotonic() + _PUBLISH_WAIT_S
        while not publisher.get_subscription_count() and time.monotonic() < end:
            rclpy.spin_once(node, timeout_sec=0.02)
        print("publisher: beginning loop")
        count = 0
        while rclpy.ok():
            count += 1
            print(f"publishing #{count}: {message!r}\n", flush=True)
            publisher.publish(message)
            if arguments.once:
                break
            rclpy.spin_once(node, timeout_sec=1.0 / arguments.rate)
        # What was sent last must arrive before the publisher is gone.
        publisher.wait_for_all_acked()
