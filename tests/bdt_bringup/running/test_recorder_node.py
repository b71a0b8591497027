"""The recorder writes every topic byte for byte and tells a lockstep plant how far it is."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from rclpy.node import Node
from rclpy.serialization import serialize_message
from rosbags.highlevel import AnyReader
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import Float64MultiArray

from bdt_bringup.running.recorder_node import RecorderNode
from bdt_msgs_py.node_parameters import ConfigurationError
from bdt_msgs_py.qos import qos_profile
from bdt_msgs_py.reading import nanoseconds_from_stamp
from bdt_msgs_py.topics import ALL_TOPICS, COMMAND, MEASUREMENT, PROGRESS, TELEMETRY
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
    publisher[TELEMETRY].publish(sample_message(np.zeros((3, 3)), COLUMNS))
    progress = []
    talker.create_subscription(TimeReference, PROGRESS.name, progress.append, qos_profile(PROGRESS))
    ros.spin_until(lambda: len(progress) >= 2)
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


def test_a_folder_that_exists_is_never_written_to(ros, tmp_path):
    with pytest.raises(ConfigurationError, match="exists already"):
        ros.create(RecorderNode, bag=str(tmp_path))
