"""``ros2 topic``: topics, their types and endpoints. What carries messages has its own modules."""

import argparse
from typing import Any

from rclpy.node import Node
from rclpy.topic_endpoint_info import TopicEndpointInfo
from ros2cli import topic_echo, topic_hz, topic_pub
from ros2cli.errors import CommandError
from ros2cli.node_session import (
    add_group,
    add_node_arguments,
    command_node,
    full_topic_name,
    is_hidden,
    wait_for_node_names,
)

__all__ = ["add_commands"]


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    verbs = add_group(groups, "topic", "Various topic related sub-commands")
    topic_echo.add_verb(verbs)
    verb = verbs.add_parser("find", help="Output a list of available topics of a given type")
    verb.add_argument("topic_type", help="Name of the topic type (e.g. 'std_msgs/msg/String')")
    _add_list_arguments(verb)
    verb.set_defaults(main=_find)
    topic_hz.add_verb(verbs)
    verb = verbs.add_parser("info", help="Print information about a topic")
    verb.add_argument("topic_name")
    verb.add_argument("-v", "--verbose", action="store_true", help="Print nodes, QoS and hashes")
    add_node_arguments(verb)
    verb.set_defaults(main=_info)
    verb = verbs.add_parser("list", help="Output a list of available topics")
    verb.add_argument("-t", "--show-types", action="store_true", help="Additionally show the type")
    verb.add_argument(
        "-v", "--verbose", action="store_true", help="List full details about each topic"
    )
    _add_list_arguments(verb)
    verb.set_defaults(main=_list)
    topic_pub.add_verb(verbs)
    verb = verbs.add_parser("type", help="Print a topic's type")
    verb.add_argument("topic_name")
    add_node_arguments(verb)
    verb.set_defaults(main=_type)


def _add_list_arguments(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("-c", "--count-topics", action="store_true", help="Only display the number")
    verb.add_argument("--include-hidden-topics", action="store_true", help="Consider hidden topics")
    add_node_arguments(verb)


def _others(node: Node, infos: list[TopicEndpointInfo]) -> list[TopicEndpointInfo]:
    """Endpoints that are not this command's own."""
    return [info for info in infos if info.node_name != node.get_name()]


def _topics(
    node: Node, *, include_hidden: bool
) -> list[tuple[str, list[str], list[TopicEndpointInfo], list[TopicEndpointInfo]]]:
    """Names, types, publishers and subscriptions of the topics that others use."""
    found = []
    for name, types in node.get_topic_names_and_types():
        publishers = _others(node, node.get_publishers_info_by_topic(name))
        subscriptions = _others(node, node.get_subscriptions_info_by_topic(name))
        if (publishers or subscriptions) and (include_hidden or not is_hidden(name)):
            found.append((name, types, publishers, subscriptions))
    return found


def _list(arguments: argparse.Namespace) -> None:
    with command_node(arguments.spin_time) as node:
        topics = _topics(node, include_hidden=arguments.include_hidden_topics)
    if arguments.count_topics:
        print(len(topics))
    elif arguments.verbose:
        print("Published topics:")
        for name, types, publishers, _ in topics:
            _print_count(name, types, len(publishers), "publisher")
        print("\nSubscribed topics:")
        for name, types, _, subscriptions in topics:
            _print_count(name, types, len(subscriptions), "subscriber")
        print()
    else:
        for name, types, _, _ in topics:
            print(f"{name} [{', '.join(types)}]" if arguments.show_types else name)


def _print_count(name: str, types: list[str], count: int, what: str) -> None:
    if count:
        print(f" * {name} [{', '.join(types)}] {count} {what}{'s' if count > 1 else ''}")


def _find(arguments: argparse.Namespace) -> None:
    with command_node(arguments.spin_time) as node:
        topics = _topics(node, include_hidden=arguments.include_hidden_topics)
    names = [name for name, types, _, _ in topics if arguments.topic_type in types]
    print(*([len(names)] if arguments.count_topics else names), sep="\n", end="\n" if names else "")


def _type(arguments: argparse.Namespace) -> int:
    with command_node(arguments.spin_time) as node:
        name = full_topic_name(node, arguments.topic_name)
        types = dict(node.get_topic_names_and_types()).get(name, [])
    for type_name in types:
        print(type_name)
    return 0 if types else 1


def _info(arguments: argparse.Namespace) -> None:
    with command_node(arguments.spin_time) as node:
        name = full_topic_name(node, arguments.topic_name)
        types = dict(node.get_topic_names_and_types()).get(name)
        if types is None:
            raise CommandError(f"Unknown topic '{arguments.topic_name}'")
        if arguments.verbose:
            wait_for_node_names(node)
        end = "\n\n" if arguments.verbose else "\n"
        print("Type:", types[0] if len(types) == 1 else types, end=end)
        for title, infos in (
            ("Publisher", node.get_publishers_info_by_topic(name)),
            ("Subscription", node.get_subscriptions_info_by_topic(name)),
        ):
            others = _others(node, infos)
            print(f"{title} count: {len(others)}", end=end)
            if arguments.verbose:
                for info in others:
                    print(info, end=end)
