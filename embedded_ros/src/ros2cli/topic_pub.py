"""``ros2 topic pub``: publish a message."""

import argparse
import math
import time

import rclpy
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from ros2cli.errors import CommandError
from ros2cli.messages import import_type, message_of, parse_values
from ros2cli.node_session import command_node, full_topic_name, listen, wait_until
from ros2cli.qos import profile_of_arguments

__all__ = ["pub"]

_REMIND_S = 1.0
_ARRIVE = Duration(seconds=1)


def pub(arguments: argparse.Namespace) -> None:
    """``topic pub``."""
    count = 1 if arguments.once else arguments.times
    listeners = arguments.wait_matching_subscriptions
    if listeners is None:
        listeners = 1 if count else 0
    longest = arguments.max_wait_time_secs
    if longest is not None and not listeners:
        raise CommandError(
            "--max-wait-time-secs: nothing is waited for; add --once, --times N or -w N"
        )
    kind = import_type(arguments.message_type, "msg")
    message, stamps = message_of(kind, parse_values(arguments.values))
    with command_node(name=arguments.node_name, use_sim_time=arguments.use_sim_time) as node:
        topic = full_topic_name(node, arguments.topic_name)
        publisher = node.create_publisher(kind, topic, profile_of_arguments(arguments)[0])
        _wait_for_listeners(node, publisher, listeners, math.inf if longest is None else longest)
        print("publisher: beginning loop")
        sent = 0

        def send() -> None:
            nonlocal sent
            sent += 1
            for stamp in stamps:
                stamp(node.get_clock().now().to_msg())
            if arguments.print and sent % arguments.print == 0:
                print(f"publishing #{sent}: {message!r}\n", flush=True)
            publisher.publish(message)

        send()
        timer = node.create_timer(1.0 / arguments.rate, send)
        wait_until(node, lambda: sent == count)
        node.destroy_timer(timer)
        # What was sent last must arrive before the publisher is gone.
        listen(node, arguments.keep_alive)
        publisher.wait_for_all_acked(_ARRIVE)


def _wait_for_listeners(node: Node, publisher: Publisher, wanted: int, longest: float) -> None:
    def enough() -> bool:
        return publisher.get_subscription_count() >= wanted

    deadline = time.monotonic() + longest
    while rclpy.ok() and not enough():
        print(f"Waiting for at least {wanted} matching subscription(s)...", flush=True)
        remaining = deadline - time.monotonic()
        if not wait_until(node, enough, min(_REMIND_S, remaining)) and remaining <= _REMIND_S:
            there = publisher.get_subscription_count()
            raise CommandError(f"Only {there} of {wanted} subscriptions came in {longest:g} s")
