"""``ros2 topic echo``: messages as they arrive."""

import argparse
import sys
from collections.abc import Callable
from typing import Any

import yaml

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from ros2cli.errors import CommandError, did_you_mean
from ros2cli.message_text import TextStyle, to_csv, to_yaml
from ros2cli.messages import import_type
from ros2cli.node_session import command_node, full_topic_name, wait_until
from ros2cli.qos import hear_all, profile_of_arguments
from ros2cli.topic_types import class_of_topic

__all__ = ["echo"]


def echo(arguments: argparse.Namespace) -> None:
    """``topic echo``."""
    end: Future[None] = Future()
    part, passes, write = _part(arguments), _filter(arguments), _writer(arguments)

    def arrive(message: Any, info: Any) -> None:
        chosen = part(message)
        if not end.done() and passes(chosen):
            write(chosen, info)
            sys.stdout.flush()
            if arguments.once:
                end.set_result(None)

    with command_node() as node:
        topic = full_topic_name(node, arguments.topic_name)
        if arguments.message_type:
            kind = import_type(arguments.message_type, "msg")
        else:
            kind = class_of_topic(node, arguments.topic_name, arguments.spin_time)
        profile = _profile(node, topic, arguments)
        node.create_subscription(kind, topic, arrive, profile, raw=arguments.raw)
        rclpy.spin_until_future_complete(node, end, timeout_sec=arguments.timeout)


def _profile(node: Node, topic: str, arguments: argparse.Namespace) -> QoSProfile:
    """Profile that was asked for; else one that hears all publishers that are seen."""
    profile, asked = profile_of_arguments(arguments)
    if not asked:
        wait_until(node, lambda: node.count_publishers(topic), arguments.spin_time)
        for lost in hear_all(node.get_publishers_info_by_topic(topic), profile):
            print(f"WARNING: {topic} {lost}", file=sys.stderr)
    return profile


def _part(arguments: argparse.Namespace) -> Callable[[Any], Any]:
    """What takes the part of a message that ``--field`` names."""
    path = arguments.field
    if path is None:
        return lambda message: message
    names = [name for name in path.split(".") if name]
    if not names:
        raise CommandError(f"--field '{path}' names nothing")

    def take(message: Any) -> Any:
        for name in names:
            if not hasattr(message, name):
                near = did_you_mean(name, dir(message))
                kind = type(message).__name__
                raise CommandError(f"--field '{path}': {kind} has no '{name}'{near}")
            message = getattr(message, name)
        return message

    return take


def _filter(arguments: argparse.Namespace) -> Callable[[Any], bool]:
    """What tells whether ``--filter`` lets a message pass."""
    text = arguments.filter
    if text is None:
        return lambda _message: True
    try:
        expression = compile(text.strip(), "--filter", "eval")
    except (SyntaxError, ValueError) as error:
        raise CommandError(f"--filter '{text}' is no Python expression: {error}") from None

    def passes(message: Any) -> bool:
        try:
            # The expression is the user's own, typed on the user's own command line.
            return bool(eval(expression, {"m": message}))  # noqa: S307
        except Exception as error:  # noqa: BLE001 - whatever the user's code raises
            raise CommandError(f"--filter '{text}' fails: {error}") from None

    return passes


def _writer(arguments: argparse.Namespace) -> Callable[[Any, Any], None]:
    """What prints a message, or a part of one, and when it came."""
    style = TextStyle(
        truncate_length=None if arguments.full_length else arguments.truncate_length,
        no_arr=arguments.no_arr,
        no_str=arguments.no_str,
        flow_style=arguments.flow_style,
    )
    with_info = arguments.include_message_info

    def write(chosen: Any, info: Any) -> None:
        if not hasattr(chosen, "get_fields_and_field_types"):
            if with_info:
                print(f"---Got new message, message info:---\n{info}\n---Message data:---")
            print(chosen, "---", sep="\n")
        elif arguments.csv:
            columns = [*info.values()] if with_info else []
            print(*columns, to_csv(chosen, style), sep=",")
        else:
            if with_info:
                print(yaml.dump(info), end="---\n")
            print(to_yaml(chosen, style), end="---\n")

    return write
