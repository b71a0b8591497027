"""Messages to bytes and back."""

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseWithCovariance
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, ByteMultiArray, Empty, Float64MultiArray, String
from std_srvs.srv import SetBool


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        (Bool(data=True), "0001000001"),
        (Empty(), "0001000000"),
        (String(data="hä"), "000100000400000068c3a400"),
        (Time(sec=-1, nanosec=2), "00010000ffffffff02000000"),
        (
            Float64MultiArray(data=[1.0, -2.5]),
            "0001000000000000000000000200000000000000000000000000f03f00000000000004c0",
        ),
        (SetBool.Response(success=True, message="a"), "0001000001000000020000006100"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_messages_are_little_endian_cdr(message, expected):
    # rclpy may pad to a multiple of four.
    assert serialize_message(message).hex().startswith(expected)
    assert deserialize_message(bytes.fromhex(expected), type(message)) == message


def test_nested_messages_survive():
    message = JointState(name=["a", "bc"], position=np.arange(3.0), effort=[1.5])
    message.header.stamp = Time(sec=5)
    message.header.frame_id = "base"
    again = deserialize_message(serialize_message(message), JointState)
    assert again == message
    assert again.position.typecode == "d"
    pose = PoseWithCovariance(covariance=np.arange(36.0))
    pose.pose.orientation.w = 0.5
    again = deserialize_message(serialize_message(pose), PoseWithCovariance)
    assert np.array_equal(again.covariance, pose.covariance)
    assert again.pose == pose.pose
    data = ByteMultiArray(data=[b"\x01", b"\xff"])
    assert deserialize_message(serialize_message(data), ByteMultiArray) == data


def test_what_was_received_can_be_changed():
    message = deserialize_message(serialize_message(JointState(position=[1.0])), JointState)
    message.position[0] = 2.0
    message.position.append(3.0)
    assert list(message.position) == [2.0, 3.0]


@pytest.mark.parametrize("payload", [b"\0\1\0\0", b"\0\1\0\0\xff\0\0\0ab"])
def test_bytes_that_are_no_message_are_an_error(payload):
    with pytest.raises(RuntimeError):
        deserialize_message(payload, String)


def test_what_is_no_message_is_an_error():
    with pytest.raises((TypeError, AttributeError)):
        serialize_message(5)
    with pytest.raises(AttributeError):
        deserialize_message(b"\0\1\0\0\0", int)
