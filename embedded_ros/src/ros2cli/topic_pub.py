"""``ros2 topic pub``: publish a message."""

import argparse
import time
from typing import Any

import rclpy
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from ros2cli.errors import CommandError
from ros2cli.messages import fill, import_type, parse_values
from ros2cli.node_session import command_node, full_topic_name, spin_for, spin_until
from ros2cli.number_arguments import not_negative_float, not_negative_int, positive_float
from ros2cli.qos_options import add_qos_arguments, profile_of_arguments

__all__ = ["add_verb"]

_REMIND_AFTER_S = 1.0


def add_verb(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = verbs.add_parser("pub", help="Publish a message to a topic")
    verb.add_argument("topic_name")
    verb.add_argument("message_type", help="Type of the message (e.g. 'std_msgs/String')")
    verb.add_argument("values", nargs="?", default="{}", help="Values of the fields, in YAML")
    verb.add_argument(
        "-r", "--rate", metavar="N", type=positive_float, default=1.0, help="Rate in Hz"
    )
    verb.add_argument(
        "-p", "--print", metavar="N", type=int, default=1, help="Only print every N-th message"
    )
    group = verb.add_mutually_exclusive_group()
    group.add_argument("-1", "--once", action="store_true", help="Publish one message and exit")
    group.add_argument(
        "-t", "--times", type=not_negative_int, default=0, help="Publish this often and exit"
    )
    verb.add_argument(
        "-w",
        "--wait-matching-subscriptions",
        type=not_negative_int,
        help="Wait for this many subscriptions (default: 1 with --once or --times, otherwise 0)",
    )
    verb.add_argument(
        "--max-wait-time-secs", type=positive_float, help="Longest wait for subscriptions"
    )
    verb.add_argument(
        "--keep-alive",
        metavar="N",
        type=not_negative_float,
        default=0.1,
        help="Keep the node alive for N seconds after the last message (default: %(default)s)",
    )
    verb.add_argument("-n", "--node-name", help="Name of the created publishing node")
    verb.add_argument(
        "-s", "--use-sim-time", action="store_true", help="Enable ROS simulation time"
    )
    add_qos_arguments(verb, "default")
    verb.set_defaults(main=_pub)


def _pub(arguments: argparse.Namespace) -> None:
    message_class = import_type(arguments.message_type, "msg", "The passed message type is invalid")
    values = parse_values(arguments.values)
    times = 1 if arguments.once else arguments.times
    wanted = arguments.wait_matching_subscriptions
    wanted = int(times != 0) if wanted is None else wanted
    if not wanted and arguments.max_wait_time_secs is not None:
        raise CommandError(
            "--max-wait-time-secs option is only effective with "
            "--wait-matching-subscriptions, --once or --times"
        )
    message = message_class()
    stamps = fill(message, values)
    with command_node(name=arguments.node_name, use_sim_time=arguments.use_sim_time) as node:
        topic = full_topic_name(node, arguments.topic_name)
        profile, _ = profile_of_arguments(arguments)
        publisher = node.create_publisher(message_class, topic, profile)
        _wait_for_subscriptions(node, publisher, wanted, arguments.max_wait_time_secs)
        print("publisher: beginning loop")
        count = 0

        def publish() -> None:
            nonlocal count
            for stamp in stamps:
                stamp(node.get_clock().now().to_msg())
            count += 1
            if arguments.print and count % arguments.print == 0:
                print(f"publishing #{count}: {message!r}\n", flush=True)
            publisher.publish(message)

        publish()
        timer = node.create_timer(1.0 / arguments.rate, publish)
        while rclpy.ok() and (not times or count < times):
            rclpy.spin_once(node)
        node.destroy_timer(timer)
        # What was sent last must arrive before the publisher is gone.
        spin_for(node, arguments.keep_alive)
        publisher.wait_for_all_acked(Duration(seconds=1))


def _wait_for_subscriptions(
    node: Any, publisher: Publisher, wanted: int, longest: float | None
) -> None:
    end = None if longest is None else time.monotonic() + longest

    def enough() -> bool:
        return publisher.get_subscription_count() >= wanted

    while rclpy.ok() and not enough():
        if end is not None and time.monotonic() >= end:
            raise CommandError(
                f"Timed out waiting for subscribers: Expected {wanted} subcribers "
                f"but only got {publisher.get_subscription_count()} subscribers"
            )
        print(f"Waiting for at least {wanted} matching subscription(s)...", flush=True)
        left = _REMIND_AFTER_S if end is None else end - time.monotonic()
        spin_until(node, enough, min(_REMIND_AFTER_S, left))
