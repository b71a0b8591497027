"""``ros2 topic hz``: how often messages arrive."""

import argparse
from collections import deque

import numpy as np

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.qos import qos_profile_sensor_data
from ros2cli.node_session import command_node
from ros2cli.topic_types import class_of_topic

__all__ = ["hz"]

_SECOND = 10**9


def hz(arguments: argparse.Namespace) -> None:
    """``topic hz``: tells the rate once a second of the clock."""
    with command_node(use_sim_time=arguments.use_sim_time) as node:
        topic = arguments.topic_name
        kind = class_of_topic(node, topic, arguments.spin_time, patient=True)
        by_wall = Clock(clock_type=ClockType.SYSTEM_TIME)
        clock = by_wall if arguments.wall_time else node.get_clock()
        # Between n + 1 messages are n gaps.
        times: deque[int] = deque(maxlen=arguments.window + 1)
        told_at: int | None = None

        def arrive(_payload: bytes) -> None:
            nonlocal told_at
            now = clock.now().nanoseconds
            if times and times[-1] > now:
                print("time has reset, resetting counters")
                times.clear()
                told_at = None
            times.append(now)
            if told_at is None:
                told_at = now
            elif now - told_at >= _SECOND:
                told_at = now
                print(_statistics(np.diff(list(times)) / _SECOND), flush=True)

        # Nothing is decoded: the bytes tell when they came.
        node.create_subscription(kind, topic, arrive, qos_profile_sensor_data, raw=True)
        rclpy.spin(node)


def _statistics(gaps: np.ndarray) -> str:
    """Rate and spread of the gaps between messages, in seconds."""
    mean = gaps.mean()
    return (
        f"average rate: {1.0 / mean if mean else 0.0:.3f}\n"
        f"\tmin: {gaps.min():.3f}s max: {gaps.max():.3f}s "
        f"std dev: {gaps.std():.5f}s window: {gaps.size}"
    )
