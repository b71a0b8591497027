"""``ros2 topic hz``: how often a topic is published."""

import argparse
import statistics
from itertools import pairwise
from typing import Any

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.qos import qos_profile_sensor_data
from ros2cli.node_session import add_node_arguments, command_node
from ros2cli.number_arguments import positive_int
from ros2cli.topic_types import message_class_of_topic, not_published_yet, type_name_of_topic

__all__ = ["add_verb"]

_NANOSECONDS = 1e9


def add_verb(verbs: Any) -> None:
    """Add the verb to the parser."""
    verb = verbs.add_parser("hz", help="Print the average publishing rate to screen")
    verb.add_argument("topic_name")
    verb.add_argument(
        "-w",
        "--window",
        type=positive_int,
        default=10000,
        help="Window size, in # of messages, for calculating rate (default: %(default)s)",
    )
    verb.add_argument("--wall-time", action="store_true", help="Calculate the rate using wall time")
    verb.add_argument(
        "-s", "--use-sim-time", action="store_true", help="Enable ROS simulation time"
    )
    add_node_arguments(verb)
    verb.set_defaults(main=_hz)


def _hz(arguments: argparse.Namespace) -> None:
    with command_node(use_sim_time=arguments.use_sim_time) as node:
        topic = arguments.topic_name
        type_name = type_name_of_topic(node, topic, arguments.spin_time)
        if type_name is None:
            print(not_published_yet(topic), flush=True)
            type_name = type_name_of_topic(node, topic, -1.0)
            if type_name is None:
                return
        wall_clock = Clock(clock_type=ClockType.SYSTEM_TIME)
        clock = wall_clock if arguments.wall_time else node.get_clock()
        arrivals: list[int] = []

        def note(_payload: bytes) -> None:
            now = clock.now().nanoseconds
            if arrivals and now < arrivals[-1]:
                print("time has reset, resetting counters")
                arrivals.clear()
            arrivals.append(now)
            del arrivals[: -arguments.window - 1]

        node.create_subscription(
            message_class_of_topic(type_name), topic, note, qos_profile_sensor_data, raw=True
        )
        shown = 0
        while rclpy.ok():
            rclpy.spin_once(node)
            if len(arrivals) < 2:
                continue
            shown = min(shown or arrivals[-1], arrivals[-1])
            if arrivals[-1] >= shown + _NANOSECONDS:
                shown = arrivals[-1]
                _print_rate([later - earlier for earlier, later in pairwise(arrivals)])


def _print_rate(gaps: list[int]) -> None:
    mean = statistics.fmean(gaps) / _NANOSECONDS
    print(f"average rate: {1.0 / mean if mean > 0 else 0.0:.3f}")
    print(
        f"\tmin: {min(gaps) / _NANOSECONDS:.3f}s max: {max(gaps) / _NANOSECONDS:.3f}s "
        f"std dev: {statistics.pstdev(gaps) / _NANOSECONDS:.5f}s window: {len(gaps)}",
        flush=True,
    )
