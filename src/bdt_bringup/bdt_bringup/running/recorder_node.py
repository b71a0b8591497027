"""Recorder as a ROS 2 node: every topic of the project into a bag, byte for byte.

``ros2 bag record`` does the same job; this node also tells a lockstep plant how far it has
come, so that nothing is lost however fast simulated time runs.
"""

import contextlib
import math
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.event_handler import QoSMessageLostInfo, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import Float64MultiArray

from bdt_bringup.bag_writing.background_writer import BackgroundWriter
from bdt_bringup.bag_writing.bag_files import BagFiles
from bdt_bringup.bag_writing.recorded_topic import BagWriteError
from bdt_bringup.running.recorder_settings import PARAMETERS, RecorderSettings
from bdt_bringup.running.strokes import spin_in_strokes
from bdt_bringup.running.topic_choice import ChosenTopic, project_topics, published_topic
from bdt_msgs_py.diagnostics import DiagnosticsPublisher, Health
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.node_parameters import ConfigurationError, declare_all, gone_if_refused
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_seconds, nanoseconds_from_stamp, read_samples
from bdt_msgs_py.topics import (
    COMMAND,
    MEASUREMENT,
    PROGRESS,
    PROGRESS_PERIOD,
    TELEMETRY,
    TELEMETRY_COLUMNS,
)
from bdt_msgs_py.writing import progress

RECORDER_NODE = "recorder"
LOOK_PERIOD = 0.2
"""Time between two looks for publishers of topics that are not the project's [s]."""


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
        with gone_if_refused(self):
            chosen, self._awaited = project_topics(self, settings.topics)
            self._writer = self._open_bag(settings)
        self._lost = 0
        self._telemetry_end = 0
        self._newest_batch = 0, 0
        self._last_measurement: bytes | None = None
        self._loop_is_here = False
        self._recording = True
        self._progress_publisher = self.create_publisher(
            TimeReference, PROGRESS.name, qos_profile(PROGRESS)
        )
        for topic in chosen:
            self._subscribe(topic)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        if self._awaited:
            self.create_timer(LOOK_PERIOD, self._look_for_publishers, clock=steady)
        self._diagnostics = DiagnosticsPublisher(self, self._health)
        self.create_timer(PROGRESS_PERIOD, self._look_for_loop, clock=steady)

    @property
    def summary(self) -> str:
        """What was recorded and what is missing, in one line."""
        written, dropped = self._writer.message_count, self._writer.dropped.total()
        return (
            f"{written} messages recorded, {dropped} dropped because of the disk, "
            f"{self._lost} lost on the way to the recorder"
        )

    def _open_bag(self, settings: RecorderSettings) -> BackgroundWriter:
        try:
            files = BagFiles(
                Path(settings.bag),
                storage=settings.storage,
                compression=settings.compression,
                split_size=settings.split_size,
                split_duration=settings.split_duration,
            )
        except FileExistsError as error:
            raise ConfigurationError(
                f"parameter bag = {settings.bag!r}: exists already, must be a new folder"
            ) from error
        except (OSError, BagWriteError) as error:
            raise ConfigurationError(f"parameter bag = {settings.bag!r}: {error}") from error
        return BackgroundWriter(files, self._tell)

    def _tell(self, text: str) -> None:
        # The log may lie on the very disk that is full; /diagnostics and the bag tell it, too.
        with contextlib.suppress(OSError):
            self.get_logger().error(text)

    def _subscribe(self, chosen: ChosenTopic) -> None:
        number = self._writer.add_topic(chosen.recorded)

        def record(data: bytes, info: dict[str, int]) -> None:
            if not self._recording:
                return
            self.messages += 1
            # A middleware does not always know when a message came, but who sent it when.
            stamp = info["received_timestamp"] or info["source_timestamp"] or time.time_ns()
            self._writer.write(number, stamp, data)
            if chosen.topic is MEASUREMENT:
                self._last_measurement = data
            elif chosen.topic is TELEMETRY:
                self._note_telemetry(data)

        self.create_subscription(
            chosen.message_type,
            chosen.recorded.name,
            record,
            chosen.profile,
            raw=True,
            event_callbacks=SubscriptionEventCallbacks(message_lost=self._note_loss),
        )

    def _look_for_publishers(self) -> None:
        for name in self._awaited[:]:
            try:
                found = published_topic(self, name)
            except ValueError as error:
                self.get_logger().error(str(error))
                self._awaited.remove(name)
                continue
            if found is not None:
                self._awaited.remove(name)
                self._subscribe(found)

    def _note_loss(self, event: QoSMessageLostInfo) -> None:
        self._lost += event.total_count_change

    def _health(self) -> Health:
        trouble, dropped = self._writer.trouble, self._writer.dropped.total()
        values = {"messages_dropped": dropped, "messages_lost": self._lost}
        if trouble or dropped:
            return Health(False, f"recording is incomplete: {trouble or 'disk is slow'}", values)
        return Health(True, "recording", values)

    def _note_telemetry(self, data: bytes) -> None:
        try:
            rows = read_samples(deserialize_message(data, Float64MultiArray), TELEMETRY_COLUMNS)
        except ValueError as error:
            self.get_logger().warning(f"odd telemetry: {error}", throttle_duration_sec=1.0)
            return
        if len(rows) and np.isfinite(rows[[0, -1], 0]).all():
            begin, end = (nanoseconds_from_seconds(time) for time in rows[[0, -1], 0])
            self._newest_batch = begin, end
        self._tell_progress()

    def _look_for_loop(self) -> None:
        """Tell the progress as long as there is a loop whose messages come here."""
        sources = (MEASUREMENT, COMMAND, TELEMETRY)
        self._loop_is_here = all(self.count_publishers(topic.name) for topic in sources)
        self._tell_progress()

    def _tell_progress(self) -> None:
        begin, end = self._newest_batch
        # Every topic has a queue of its own. Telemetry, which is rare, may be at its end when the
        # measurements of that time still wait in theirs.
        if self._measured_until() >= begin:
            self._telemetry_end = end
        if self._loop_is_here:
            self._progress_publisher.publish(progress(self.get_name(), self._telemetry_end, None))

    def _measured_until(self) -> float:
        """Return the stamp [ns] of the newest measurement taken; infinite without measurements."""
        if self._last_measurement is None:
            return math.inf
        stamp = deserialize_message(self._last_measurement, JointState).header.stamp
        return nanoseconds_from_stamp(stamp)

    def destroy_node(self) -> None:
        """Close the bag and destroy the node."""
        if self._recording:
            self._recording = False
            try:
                self._writer.close({"messages_lost": str(self._lost)})
            except BagWriteError as error:
                self._tell(
                    f"the bag could not be closed: {error}: `bdt recover` makes a whole one of it"
                )
            if self._writer.dropped:
                self._tell(self.summary)
        super().destroy_node()


def main(args: list[str] | None = None) -> None:
    """Run the recorder node; the console script ``recorder_node``."""
    sys.exit(run_node(RecorderNode, args, spin=spin_in_strokes))


if __name__ == "__main__":
    main()
