"""``ros2 topic echo``: the messages of a topic."""

import argparse
from collections.abc import Callable
from typing import Any

import yaml

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future
from ros2cli.errors import CommandError
from ros2cli.message_text import TextStyle, to_csv, to_yaml
from ros2cli.messages import import_type
from ros2cli.node_session import add_node_arguments, command_node, full_topic_name, spin_until
from ros2cli.qos_options import add_qos_arguments, compatible_policies, profile_of_arguments
from ros2cli.topic_types import message_class_of_topic, not_published_yet, type_name_of_topic

__all__ = ["add_verb"]

_DEFAULT_TRUNCATE_LENGTH = 128


def add_verb(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = verbs.add_parser("echo", help="Output messages from a topic")
    verb.add_argument("topic_name")
    verb.add_argument("message_type", nargs="?", help="Found out if somebody uses the topic")
    verb.add_argument("--once", action="store_true", help="Print the first message and exit")
    verb.add_argument(
        "--timeout", metavar="N", type=float, help="Exit after this many seconds in any case"
    )
    verb.add_argument("--csv", action="store_true", help="Output all fields in one line")
    verb.add_argument("--field", metavar="A.B", help="Echo a selected field of a message")
    verb.add_argument("--filter", metavar="EXPR", help="Python expression of the message m")
    verb.add_argument("--raw", action="store_true", help="Echo the raw binary representation")
    verb.add_argument("-f", "--full-length", action="store_true", help="Truncate nothing")
    verb.add_argument(
        "-l",
        "--truncate-length",
        metavar="N",
        type=int,
        default=_DEFAULT_TRUNCATE_LENGTH,
        help="Length to truncate arrays and strings to (default: %(default)s)",
    )
    verb.add_argument("--no-arr", action="store_true", help="Don't print array fields of messages")
    verb.add_argument("--no-str", action="store_true", help="Don't print string fields of messages")
    verb.add_argument("--flow-style", action="store_true", help="Print a message in one line")
    verb.add_argument(
        "-i", "--include-message-info", action="store_true", help="Show the message info"
    )
    add_qos_arguments(verb, "sensor_data")
    add_node_arguments(verb)
    verb.set_defaults(main=_echo)


def _echo(arguments: argparse.Namespace) -> None:
    done: Future[bool] = Future()
    show = _printer(arguments, done)
    with command_node() as node:
        topic = full_topic_name(node, arguments.topic_name)
        if arguments.message_type:
            complaint = "The passed message type is invalid"
            message_class = import_type(arguments.message_type, "msg", complaint)
        else:
            type_name = type_name_of_topic(node, topic, arguments.spin_time)
            if type_name is None:
                print(not_published_yet(arguments.topic_name))
                raise CommandError("Could not determine the type for the passed topic")
            message_class = message_class_of_topic(type_name)
        profile = _profile(node, topic, arguments)
        node.create_subscription(message_class, topic, show, profile, raw=arguments.raw)
        rclpy.spin_until_future_complete(node, done, timeout_sec=arguments.timeout)


def _profile(node: Node, topic: str, arguments: argparse.Namespace) -> QoSProfile:
    profile, chosen = profile_of_arguments(arguments)
    if not chosen:
        spin_until(node, lambda: node.count_publishers(topic), arguments.spin_time)
        publishers = node.get_publishers_info_by_topic(topic)
        for policy, substitute in compatible_policies(publishers, profile):
            print(
                f"Some, but not all, publishers are offering {policy}. Falling back to "
                f"{substitute} as it will connect to all publishers"
            )
    return profile


def _printer(arguments: argparse.Namespace, done: "Future[bool]") -> Callable[[Any, Any], None]:
    """Callback that prints a message."""
    path = (
        None if arguments.field is None else [name for name in arguments.field.split(".") if name]
    )
    if path == []:
        raise CommandError(f"Invalid field value '{arguments.field}'")
    try:
        condition = compile(arguments.filter or "True", "--filter", "eval")
    except SyntaxError as error:
        raise CommandError(f"Invalid filter '{arguments.filter}': {error.msg}") from None
    style = TextStyle(
        truncate_length=None if arguments.full_length else arguments.truncate_length,
        no_arr=arguments.no_arr,
        no_str=arguments.no_str,
        flow_style=arguments.flow_style,
    )

    def show(message: Any, info: Any) -> None:
        for name in path or ():
            if not hasattr(message, name):
                raise CommandError(
                    f"Invalid field '{arguments.field}': "
                    f"'{type(message).__name__}' object has no attribute '{name}'"
                )
            message = getattr(message, name)
        # The expression is the user's own, typed on the user's own command line.
        if done.done() or not eval(condition, {"m": message}):  # noqa: S307
            return
        if arguments.once:
            done.set_result(True)
        is_message = hasattr(message, "get_fields_and_field_types")
        if is_message and arguments.csv:
            prefix = [str(value) for value in info.values()] * arguments.include_message_info
            print(*prefix, to_csv(message, style), sep=",")
        elif is_message:
            if arguments.include_message_info:
                print(yaml.dump(info), end="---\n")
            print(to_yaml(message, style), end="---\n", flush=True)
            return
        else:
            if arguments.include_message_info:
                print("---Got new message, message info:---", info, sep="\n")
                print("---Message data:---")
            print(message, end="\n---\n")
        print(end="", flush=True)

    return show
