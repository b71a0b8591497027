"""Recorder as a ROS 2 node: every topic of the project into a bag, byte for byte.

``ros2 bag record`` does the same job; this node also tells a lockstep plant how far it has
come, so that nothing is lost however fast simulated time runs.
"""

import math
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.signals import uninstall_signal_handlers
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer, WriterError
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import TimeReference
from std_msgs.msg import Float64MultiArray

from bdt_bringup.running.recorder_settings import PARAMETERS
from bdt_bringup.running.stop_signals import StopSignals
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.node_parameters import ConfigurationError, declare_all, gone_if_refused
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_seconds, read_samples
from bdt_msgs_py.topics import (
    ALL_TOPICS,
    COMMAND,
    MEASUREMENT,
    PROGRESS,
    PROGRESS_PERIOD,
    TELEMETRY,
    TELEMETRY_COLUMNS,
    Topic,
)
from bdt_msgs_py.writing import progress

RECORDER_NODE = "recorder"
STROKE = 0.005
"""Wall time [s] between two looks at what has arrived."""

HISTORY = 10_000
"""Messages a subscription may hold back while the recorder is busy."""


class RecorderNode(Node):
    """Writes what arrives, with the wall time of its arrival.

    Parameters
    ----------
    **node_arguments
        Passed on to :class:`rclpy.node.Node`, for example ``context`` or ``parameter_overrides``.

    Raises
    ------
    ConfigurationError
        For a parameter that is unknown or not allowed, or a bag that cannot be created.
    """

    def __init__(self, **node_arguments: Any) -> None:
        super().__init__(RECORDER_NODE, **node_arguments)
        self._recording = False
        self.messages = 0
        (settings,) = declare_all(self, PARAMETERS)
        plugin = StoragePlugin.MCAP if settings.storage == "mcap" else StoragePlugin.SQLITE3
        with gone_if_refused(self):
            try:
                self._writer = Writer(Path(settings.bag), version=9, storage_plugin=plugin)
                self._writer.open()
            except (WriterError, OSError) as error:
                raise ConfigurationError(f"parameter bag = {settings.bag!r}: {error}") from error
        self._telemetry_end = 0
        self._recording = True
        self._progress_publisher = self.create_publisher(
            TimeReference, PROGRESS.name, qos_profile(PROGRESS)
        )
        store = get_typestore(Stores.ROS2_JAZZY)
        for topic in ALL_TOPICS:
            connection = self._writer.add_connection(
                self.resolve_topic_name(topic.name),
                topic.message_type,
                typestore=store,
                offered_qos_profiles=[_recorded_qos(topic)],
            )
            self._subscribe(topic, connection)
        self.create_timer(
            PROGRESS_PERIOD, self._tell_progress, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def _subscribe(self, topic: Topic, connection: Any) -> None:
        package, _, name = topic.message_type.split("/")
        message_type = getattr(import_module(f"{package}.msg"), name)

        def record(data: bytes, info: dict[str, int]) -> None:
            if not self._recording:
                return
            self.messages += 1
            # A middleware that does not know when a message came says 0.
            self._writer.write(connection, info["received_timestamp"] or time.time_ns(), data)
            if topic is TELEMETRY:
                self._note_telemetry(data)

        self.create_subscription(
            message_type, topic.name, record, qos_profile(topic, depth=HISTORY), raw=True
        )

    def _note_telemetry(self, data: bytes) -> None:
        try:
            rows = read_samples(deserialize_message(data, Float64MultiArray), TELEMETRY_COLUMNS)
        except ValueError as error:
            self.get_logger().warning(f"odd telemetry: {error}", throttle_duration_sec=1.0)
            return
        if len(rows) and math.isfinite(rows[-1, 0]):
            self._telemetry_end = nanoseconds_from_seconds(rows[-1, 0])
        self._tell_progress()

    def _tell_progress(self) -> None:
        sources = (MEASUREMENT, COMMAND, TELEMETRY)
        if all(self.count_publishers(topic.name) for topic in sources):
            self._progress_publisher.publish(progress(self.get_name(), self._telemetry_end, None))

    def destroy_node(self) -> None:
        """Close the bag and destroy the node."""
        if self._recording:
            self._recording = False
            self._writer.close()
        super().destroy_node()


def _recorded_qos(topic: Topic) -> Qos:
    unlimited = QosTime(2147483647, 4294967295)
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=topic.depth,
        reliability=QosReliability.RELIABLE if topic.reliable else QosReliability.BEST_EFFORT,
        durability=QosDurability.TRANSIENT_LOCAL
        if topic.transient_local
        else QosDurability.VOLATILE,
        deadline=unlimited,
        lifespan=unlimited,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=unlimited,
        avoid_ros_namespace_conventions=False,
    )


def record_in_strokes(executor: SingleThreadedExecutor, node: RecorderNode) -> None:
    """Record until a signal comes, and then what has arrived before it.

    An executor that waits is woken by every message, twice in a control period, and on a small
    computer each time in the way of the controller. Here messages gather while nobody waits.

    Parameters
    ----------
    executor : SingleThreadedExecutor
        Executor that has the node.
    node : RecorderNode
        The recorder.
    """
    uninstall_signal_handlers()
    with StopSignals() as signals:
        while True:
            stopping, taken = signals.requested, node.messages
            executor.spin_once(timeout_sec=0.0)
            if node.messages > taken:
                continue
            if stopping:
                return
            time.sleep(STROKE)


def main(args: list[str] | None = None) -> None:
    """Run the recorder node; the console script ``recorder_node``."""
    sys.exit(run_node(RecorderNode, args, spin=record_in_strokes))


if __name__ == "__main__":
    main()
