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

from rclpy.clock import Clock, ClockType
from rclpy.event_handler import QoSMessageLostInfo, SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import Float64MultiArray

from bdt_bags.recorder.recorder_settings import PARAMETERS, RecorderSettings
from bdt_bags.recorder.topic_choice import ChosenTopic, project_topics, published_topic
from bdt_bags.writing.background_writer import BackgroundWriter
from bdt_bags.writing.bag_files import BagFiles
from bdt_bags.writing.topic_metadata import BagWriteError
from bdt_msgs_py.admission import Admission
from bdt_msgs_py.clock_check import keep_wall_time
from bdt_msgs_py.command_errors import LoopError
from bdt_msgs_py.diagnostics import DiagnosticsPublisher, Health
from bdt_msgs_py.message_checks import check_stamp, check_telemetry_times
from bdt_msgs_py.node_main import run_node
from bdt_msgs_py.node_parameters import ConfigurationError, declare_all, destroy_on_error
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_seconds
from bdt_msgs_py.rejection import MessageRejectedError
from bdt_msgs_py.sole_publisher import publisher_count
from bdt_msgs_py.spinning import spin_at_intervals
from bdt_msgs_py.telemetry_sequence import TelemetrySequence
from bdt_msgs_py.topics import (
    COMMAND,
    MEASUREMENT,
    PROGRESS,
    PROGRESS_PERIOD,
    RECORDER_NODE,
    TELEMETRY,
)
from bdt_msgs_py.writing import progress

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
        with destroy_on_error(self):
            chosen, self._awaited = project_topics(self, settings.topics)
            self._writer = self._open_bag(settings)
        self._bag = settings.bag
        self._lost = 0
        self._telemetry_end = 0
        self._newest_batch = 0, 0
        self._sequence = TelemetrySequence()
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
        self._admission = Admission(self)
        keep_wall_time(self, "a bag is stamped with the wall time")
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

    @property
    def dropped(self) -> int:
        """Number of messages that the disk did not take."""
        return self._writer.dropped.total()

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
        return BackgroundWriter(files, self._log)

    def _log(self, text: str) -> None:
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
        disk_error, dropped = self._writer.disk_error, self._writer.dropped.total()
        values = {"messages_dropped": dropped, "messages_lost": self._lost}
        health = Health(True, "recording", values)
        if disk_error or dropped:
            text = f"recording is incomplete: {disk_error or 'disk is slow'}"
            health = Health(False, text, values)
        return self._admission.complete(health)

    def _note_telemetry(self, data: bytes) -> None:
        """Note what the newest telemetry is; strays are recorded, but say nothing of the loop."""
        try:
            rows = check_telemetry_times(deserialize_message(data, Float64MultiArray))
            measured = self._measured_until() * 1e-9
            expected = measured if math.isfinite(measured) else None
            admitted = self._sequence.admit(rows, time.monotonic(), expected)
        except MessageRejectedError as error:
            self._admission.reject(TELEMETRY, error)
            return
        if admitted.stray is not None:
            self._admission.reject(TELEMETRY, admitted.stray)
        if not admitted.batches:
            return
        newest = admitted.batches[-1][:, 0]
        self._newest_batch = (
            nanoseconds_from_seconds(newest[0]),
            nanoseconds_from_seconds(newest[-1]),
        )
        self._publish_progress()

    def _look_for_loop(self) -> None:
        """Tell the progress as long as there is a loop whose messages come here."""
        sources = (MEASUREMENT, COMMAND, TELEMETRY)
        self._loop_is_here = all(publisher_count(self, topic) for topic in sources)
        self._publish_progress()

    def _publish_progress(self) -> None:
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
        try:
            return check_stamp(deserialize_message(self._last_measurement, JointState).header.stamp)
        except MessageRejectedError:
            return -math.inf  # a stray: the next measurement tells

    def close_bag(self) -> None:
        """End the recording, if that has not been done.

        Raises
        ------
        LoopError
            If the bag could not be closed; the text says what to do about it.
        """
        if not self._recording:
            return
        self._recording = False
        try:
            self._writer.close({"messages_lost": str(self._lost)})
        except BagWriteError as error:
            raise LoopError(
                f"{self._bag} has no end: {error}: `bdt recover` makes a whole one of it"
            ) from error
        finally:
            if self._writer.dropped:
                self._log(self.summary)

    def destroy_node(self) -> None:
        """Close the bag and destroy the node."""
        try:
            self.close_bag()
        except LoopError as error:
            self._log(str(error))
        super().destroy_node()


def record_until_stopped(executor: SingleThreadedExecutor, node: RecorderNode) -> None:
    """Run the callbacks of a recorder until a signal comes, and close its bag.

    Parameters
    ----------
    executor : SingleThreadedExecutor
        Executor that has the node.
    node : RecorderNode
        The node.

    Raises
    ------
    LoopError
        If the bag could not be closed.
    """
    spin_at_intervals(executor, node)
    node.close_bag()


def main(args: list[str] | None = None) -> None:
    """Run the recorder node; the console script ``recorder_node``."""
    sys.exit(run_node(RecorderNode, args, spin=record_until_stopped, is_configured=False))


if __name__ == "__main__":
    main()
