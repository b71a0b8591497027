"""``ros2 topic`` but for messages: which topics there are, and who uses them."""

import argparse

from ros2cli.errors import CommandError, did_you_mean
from ros2cli.graph import Topic, node_names, others, print_names, topics
from ros2cli.node_session import command_node, full_topic_name

__all__ = ["show_information", "show_of_type", "show_topics", "show_type"]


def _found(arguments: argparse.Namespace) -> list[Topic]:
    with command_node(arguments.spin_time) as node:
        return topics(node, hidden=arguments.include_hidden_topics)


def show_topics(arguments: argparse.Namespace) -> None:
    """``topic list``."""
    found = _found(arguments)
    if not arguments.verbose or arguments.count_topics:
        names = [(topic.name, topic.types) for topic in found]
        print_names(names, types=arguments.show_types, count=arguments.count_topics)
        return
    for title, noun, users in (
        ("Published", "publisher", [topic.publishers for topic in found]),
        ("Subscribed", "subscriber", [topic.subscriptions for topic in found]),
    ):
        print(f"{title} topics:")
        for topic, endpoints in zip(found, users, strict=True):
            if count := len(endpoints):
                plural = "s" * (count > 1)
                print(f" * {topic.name} [{', '.join(topic.types)}] {count} {noun}{plural}")
        print()


def show_of_type(arguments: argparse.Namespace) -> None:
    """``topic find``."""
    matching = [topic for topic in _found(arguments) if arguments.topic_type in topic.types]
    print_names(((topic.name, []) for topic in matching), count=arguments.count_topics)


def show_type(arguments: argparse.Namespace) -> int:
    """``topic type``: silence and exit code 1 for a topic that nobody uses."""
    with command_node(arguments.spin_time) as node:
        known = dict(node.get_topic_names_and_types())
        types = known.get(full_topic_name(node, arguments.topic_name), [])
    print_names((name, []) for name in types)
    return 0 if types else 1


def show_information(arguments: argparse.Namespace) -> None:
    """``topic info``."""
    typed = arguments.topic_name
    with command_node(arguments.spin_time) as node:
        name = full_topic_name(node, typed)
        known = dict(node.get_topic_names_and_types())
        if name not in known:
            raise CommandError(f"Unknown topic '{typed}'{did_you_mean(name, known)}")
        if arguments.verbose:
            # The information tells names, and they may be late.
            node_names(node)
        publishers = others(node, node.get_publishers_info_by_topic(name))
        subscriptions = others(node, node.get_subscriptions_info_by_topic(name))
    (single, *more) = types = known[name]
    paragraphs = [f"Type: {types if more else single}"]
    for title, endpoints in (("Publisher", publishers), ("Subscription", subscriptions)):
        paragraphs.append(f"{title} count: {len(endpoints)}")
        if arguments.verbose:
            paragraphs += map(str, endpoints)
    separator = "\n\n" if arguments.verbose else "\n"
    print(*paragraphs, sep=separator, end=separator)
