"""What the plant publishes: measurements, the clock, telemetry and truth in batches."""

import math
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray

from bdt_msgs_py.qos import publisher_profile
from bdt_msgs_py.topics import (
    CLOCK,
    MEASUREMENT,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    TRUTH,
    TRUTH_COLUMNS,
    Topic,
)
from bdt_msgs_py.writing import platform_position, sample_message, stamp_from_nanoseconds


class PlantPublishers:
    """Publishers of the plant.

    Parameters
    ----------
    node : rclpy.node.Node
        The plant.

    Attributes
    ----------
    clock, telemetry : rclpy.publisher.Publisher
        Publishers of the clock and of telemetry, for those who ask who else is on their topics.
    repeated_batches : int
        How often telemetry was published once more.
    """

    def __init__(self, node: Node) -> None:
        def publisher(message_type: Any, topic: Topic) -> Any:
            return node.create_publisher(message_type, topic.name, publisher_profile(topic))

        self._measurement = publisher(JointState, MEASUREMENT)
        self.telemetry = publisher(Float64MultiArray, TELEMETRY)
        self._truth = publisher(Float64MultiArray, TRUTH)
        self.clock = publisher(Clock, CLOCK)
        self._newest_batch, self._sent_at = Float64MultiArray(), math.inf
        self.repeated_batches = 0

    def publish_measurement(self, stamp: int, position: float) -> None:
        """Publish the position of platform 3 [m] at the time `stamp` [ns]."""
        self._measurement.publish(platform_position(stamp, position))

    def publish_clock(self, stamp: int) -> None:
        """Publish simulated time [ns]."""
        self.clock.publish(Clock(clock=stamp_from_nanoseconds(stamp)))

    def publish_batch(self, telemetry: NDArray[np.float64], truth: list[tuple[float, ...]]) -> None:
        """Publish a batch of telemetry and the truth of the same time.

        Parameters
        ----------
        telemetry : ndarray, shape (n, 3)
            Rows of the columns ``TELEMETRY_COLUMNS``.
        truth : list of tuple
            Rows of the columns ``TRUTH_COLUMNS``.
        """
        self._newest_batch = sample_message(telemetry, TELEMETRY_COLUMNS)
        self._send_newest_batch()
        self._truth.publish(sample_message(np.array(truth), TRUTH_COLUMNS))

    def repeat_telemetry(self, after: float) -> None:
        """Publish the newest telemetry once more if that was last done some time [s] ago."""
        if time.monotonic() - self._sent_at >= after:
            self.repeated_batches += 1
            self._send_newest_batch()

    def _send_newest_batch(self) -> None:
        self._sent_at = time.monotonic()
        self.telemetry.publish(self._newest_batch)
