"""The recorder writes every topic byte for byte and tells a lockstep plant how far it is."""

import errno
import itertools
import os
import signal
import subprocess
import sys
from functools import partial

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosReliability, QosTime
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import Float64MultiArray, String

from bdt_bags.bag_error import BagError
from bdt_bags.recorder.recorder_node import RecorderNode
from bdt_bags.recovery.recover_bag import recover_bag
from bdt_bags.writing import mcap_file
from bdt_msgs_py.node_parameters import ConfigurationError
from bdt_msgs_py.qos import publisher_profile, qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp
from bdt_msgs_py.topics import ALL_TOPICS, COMMAND, DIAGNOSTICS, MEASUREMENT, PROGRESS, TELEMETRY
from bdt_msgs_py.topics import TELEMETRY_COLUMNS as COLUMNS
from bdt_msgs_py.writing import motor_voltage, platform_position, sample_message


def publishers(node):
    kinds = {MEASUREMENT: JointState, COMMAND: JointState, TELEMETRY: Float64MultiArray}
    return {
        topic: node.create_publisher(kind, topic.name, qos_profile(topic))
        for topic, kind in kinds.items()
    }


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_what_is_published_stands_in_the_bag_byte_for_byte(ros, tmp_path, storage):
    recorder = ros.create(RecorderNode, bag=str(tmp_path / "bag"), storage=storage)
    talker = ros.create(Node, "talker")
    publisher = publishers(talker)
    for each in publisher.values():
        ros.spin_until(lambda each=each: each.get_subscription_count() == 1)
    sent = [platform_position(stamp, 1e-3 * stamp) for stamp in range(20)]
    for message in sent:
        publisher[MEASUREMENT].publish(message)
    publisher[COMMAND].publish(motor_voltage(0, 12.0))
    rows = np.zeros((3, 3))
    rows[:, 0] = 1e-9 * np.array([17.0, 18.0, 19.0])
    publisher[TELEMETRY].publish(sample_message(rows, COLUMNS))
    progress = []
    talker.create_subscription(TimeReference, PROGRESS.name, progress.append, qos_profile(PROGRESS))
    # Not before the last measurement is recorded.
    ros.spin_until(lambda: progress and nanoseconds_from_stamp(progress[-1].header.stamp) == 19)
    recorder.destroy_node()
    with AnyReader([tmp_path / "bag"]) as reader:
        assert {connection.topic for connection in reader.connections} == {
            "/" + topic.name.lstrip("/") for topic in ALL_TOPICS
        }
        raw = [
            bytes(data)
            for connection, _, data in reader.messages()
            if connection.topic == "/measurement"
        ]
    assert raw == [bytes(serialize_message(message)) for message in sent]


def test_it_finds_a_loop_whose_command_has_another_name(ros, tmp_path):
    remapped = ["--ros-args", "-r", "command:=/voltage"]
    ros.create(partial(RecorderNode, cli_args=remapped), bag=str(tmp_path / "bag"))
    talker = ros.create(partial(Node, cli_args=remapped), "talker")
    publishers(talker)
    progress = []
    talker.create_subscription(TimeReference, PROGRESS.name, progress.append, qos_profile(PROGRESS))
    ros.spin_until(lambda: progress)


def test_the_recorder_never_acts_on_the_loop_and_acknowledges_telemetry(ros, tmp_path):
    ros.create(RecorderNode, bag=str(tmp_path / "bag"))
    talker = ros.create(Node, "talker")
    publisher = publishers(talker)
    heard = []
    talker.create_subscription(TimeReference, PROGRESS.name, heard.append, qos_profile(PROGRESS))
    ros.spin_until(lambda: heard)
    assert heard[-1].source == "recorder"
    assert heard[-1].header.stamp == Time()
    assert heard[-1].time_ref.sec == 2**31 - 1
    rows = np.array([[0.0998, 1.0, 2.0]])
    publisher[TELEMETRY].publish(sample_message(rows, COLUMNS))
    ros.spin_until(lambda: nanoseconds_from_stamp(heard[-1].header.stamp) == 99_800_000)


def test_telemetry_counts_as_recorded_once_the_measurements_of_its_time_are(ros, tmp_path):
    """Every topic has a queue of its own, and telemetry is the shortest."""
    ros.create(RecorderNode, bag=str(tmp_path / "bag"))
    talker = ros.create(Node, "talker")
    publisher = publishers(talker)
    heard = []
    talker.create_subscription(TimeReference, PROGRESS.name, heard.append, qos_profile(PROGRESS))
    ros.spin_until(lambda: heard)

    def acknowledged():
        return nanoseconds_from_stamp(heard[-1].header.stamp)

    publisher[MEASUREMENT].publish(platform_position(98_000_000, 0.0))
    rows = np.array([[0.1, 1.0, 2.0], [0.1998, 1.0, 2.0]])
    publisher[TELEMETRY].publish(sample_message(rows, COLUMNS))
    count = len(heard)
    ros.spin_until(lambda: len(heard) > count + 3)
    assert acknowledged() == 0
    publisher[MEASUREMENT].publish(platform_position(100_000_000, 0.0))
    ros.spin_until(lambda: acknowledged() == 199_800_000)


@pytest.mark.parametrize("begin", [0.0, 3e9, 1e300, -1e300])
def test_stray_telemetry_is_recorded_and_does_not_move_the_progress(ros, tmp_path, begin):
    recorder = ros.create(RecorderNode, bag=str(tmp_path / "bag"))
    talker = ros.create(Node, "talker")
    publisher = publishers(talker)
    heard = []
    talker.create_subscription(TimeReference, PROGRESS.name, heard.append, qos_profile(PROGRESS))
    ros.spin_until(lambda: heard)
    times = 1.0 + 1e-3 * np.arange(100)
    for start in (times, begin + times - 1.0):
        rows = np.column_stack([start, times, times])
        publisher[TELEMETRY].publish(sample_message(rows, COLUMNS))
    ros.spin_until(lambda: recorder._health().values["rejected_messages"] == 1)
    count = len(heard)
    ros.spin_until(lambda: len(heard) > count + 2)
    assert nanoseconds_from_stamp(heard[-1].header.stamp) == 1_099_000_000
    ros.spin_until(lambda: recorder._writer.message_count >= 2)


def test_a_bag_has_the_wall_time(ros, tmp_path):
    recorder = ros.create(RecorderNode, bag=str(tmp_path / "bag"))
    result = recorder.set_parameters([Parameter("use_sim_time", value=True)])[0]
    assert not result.successful
    assert "a bag is stamped with the wall time" in result.reason


def test_a_folder_that_exists_is_never_written_to(ros, tmp_path):
    with pytest.raises(ConfigurationError, match="exists already"):
        ros.create(RecorderNode, bag=str(tmp_path))


def test_topics_can_be_chosen_by_name_and_need_not_be_those_of_the_project(ros, tmp_path):
    talker = ros.create(Node, "talker")
    text = talker.create_publisher(String, "chatter", 10)
    command = talker.create_publisher(JointState, COMMAND.name, qos_profile(COMMAND))
    recorder = ros.create(
        RecorderNode, bag=str(tmp_path / "bag"), topics="command /chatter", storage="sqlite3"
    )
    ros.spin_until(lambda: text.get_subscription_count() == command.get_subscription_count() == 1)
    text.publish(String(data="hello"))
    command.publish(motor_voltage(0, 12.0))
    ros.spin_until(lambda: recorder._writer.message_count == 2)
    recorder.destroy_node()
    with AnyReader([tmp_path / "bag"]) as reader:
        assert {(one.topic, one.msgtype) for one in reader.connections} == {
            ("/command", "sensor_msgs/msg/JointState"),
            ("/chatter", "std_msgs/msg/String"),
        }
        offered = {one.topic: one.ext.offered_qos_profiles[0] for one in reader.connections}
    assert offered["/chatter"].reliability == QosReliability.RELIABLE
    assert offered["/chatter"].depth in {0, 10}
    assert offered["/command"].lifespan == QosTime(9223372036, 854775807)
    assert recorder.summary.startswith("2 messages recorded, 0 dropped")


def test_a_name_that_no_topic_can_have_is_refused(ros, tmp_path):
    with pytest.raises(ConfigurationError, match="parameter topics = '0bad'"):
        ros.create(RecorderNode, bag=str(tmp_path / "bag"), topics="0bad")
    assert not (tmp_path / "bag").exists()


def test_a_full_disk_is_told_and_the_recorder_goes_on(ros, tmp_path, monkeypatch):
    recorder = ros.create(RecorderNode, bag=str(tmp_path / "bag"))
    talker = ros.create(Node, "talker")
    publisher = publishers(talker)[MEASUREMENT]
    heard = []
    talker.create_subscription(
        DiagnosticArray, DIAGNOSTICS.name, heard.append, qos_profile(DIAGNOSTICS)
    )
    ros.spin_until(lambda: publisher.get_subscription_count() == 1)

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(mcap_file.os, "pwrite", full)
        # The log lies on the same disk.
        patch.setattr(recorder.get_logger(), "error", full)
        publisher.publish(platform_position(0, 1.0))
        ros.spin_until(lambda: heard and heard[-1].status[0].level == DiagnosticStatus.WARN)
        status = heard[-1].status[0]
        assert status.name == "/recorder"
        assert "No space left on device" in status.message
    ros.spin_until(lambda: heard[-1].status[0].level == DiagnosticStatus.OK)
    recorder.destroy_node()
    with AnyReader([tmp_path / "bag"]) as reader:
        counts = {one.topic: one.msgcount for one in reader.connections}
    assert counts["/measurement"] == 1


SMALL_BUFFER = (
    "<CycloneDDS><Domain><Internal>"
    "<SocketReceiveBufferSize min='64 kB' max='64 kB'/>"
    "</Internal></Domain></CycloneDDS>"
)
"""For a recorder that cannot leave more than a few messages to its operating system."""


def recorder_process(bag, *arguments, environment=None):
    words = ["-p", f"bag:={bag}", *arguments]
    command = [sys.executable, "-m", "bdt_bags.recorder.recorder_node", "--ros-args", *words]
    return subprocess.Popen(command, env=environment)


class OnDisk:
    """What a bag that is being written holds of a topic."""

    def __init__(self, bag, topic, folder):
        self._bag, self._topic, self._folder = bag, topic, folder
        self._attempts = itertools.count()

    def messages(self):
        try:
            output = recover_bag(self._bag, self._folder / f"{next(self._attempts)}").output
        except BagError:  # nothing to recover yet
            return []
        with AnyReader([output]) as reader:
            wanted = [one for one in reader.connections if one.topic == self._topic]
            return [bytes(data) for _, _, data in reader.messages(wanted)]


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_messages_reach_the_disk_while_the_recorder_goes_on(ros, tmp_path, storage):
    """So a kill loses little: what was on the disk before it is there after it."""
    bag = tmp_path / "bag"
    # The namespace sets this recorder apart from one that was killed, which peers miss late.
    arguments = ["-r", f"__ns:=/{storage}", "-p", f"storage:={storage}"]
    talker = ros.create(Node, "talker")
    name = f"/{storage}/{MEASUREMENT.name}"
    publisher = talker.create_publisher(JointState, name, qos_profile(MEASUREMENT))
    on_disk = OnDisk(bag, name, tmp_path)
    with recorder_process(bag, *arguments) as process:
        try:
            ros.spin_until(lambda: publisher.get_subscription_count() == 1)
            sent = []
            for number in range(200):
                message = platform_position(number, 1e-3 * number)
                sent.append(bytes(serialize_message(message)))
                publisher.publish(message)
                ros.spin_for(2e-3)
            ros.spin_until(lambda: on_disk.messages() == sent)
            assert process.poll() is None
        finally:
            process.kill()
    assert on_disk.messages() == sent


@pytest.mark.parametrize("topic", [MEASUREMENT, COMMAND], ids=lambda topic: topic.name)
def test_a_recorder_whose_machine_is_busy_for_a_while_loses_nothing(ros, tmp_path, topic):
    talker = ros.create(Node, "talker")
    name = f"/busy/{topic.name}"
    publisher = talker.create_publisher(JointState, name, publisher_profile(topic))
    bag = tmp_path / "bag"
    on_disk = OnDisk(bag, name, tmp_path)
    uri = ",".join(filter(None, [os.environ.get("CYCLONEDDS_URI"), SMALL_BUFFER]))
    environment = os.environ | {"CYCLONEDDS_URI": uri}
    with recorder_process(bag, "-r", "__ns:=/busy", environment=environment) as process:
        try:
            ros.spin_until(lambda: publisher.get_subscription_count() == 1)
            messages = [platform_position(number, 0.0) for number in range(topic.kept)]
            process.send_signal(signal.SIGSTOP)
            for message in messages:
                publisher.publish(message)
            process.send_signal(signal.SIGCONT)
            sent = [bytes(serialize_message(message)) for message in messages]
            ros.spin_until(lambda: on_disk.messages() == sent)
        finally:
            process.kill()
