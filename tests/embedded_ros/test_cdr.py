"""CDR is byte for byte what Jazzy writes (vectors from rclpy 7.1.3) and what rosbags reads."""

import contextlib
import struct
import tracemalloc

import numpy as np
import pytest
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from embedded_ros.cdr import CdrError
from geometry_msgs.msg import PoseWithCovarianceStamped
from hypothesis import given
from hypothesis import strategies as st
from rcl_interfaces.msg import ParameterEvent
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import (
    Bool,
    ByteMultiArray,
    Empty,
    Float64MultiArray,
    Header,
    MultiArrayDimension,
    String,
    UInt8MultiArray,
)

STORE = get_typestore(Stores.ROS2_JAZZY)

TYPES = [Bool, ByteMultiArray, DiagnosticArray, Empty, JointState, ParameterEvent, String]

GOLDEN = [
    (
        JointState(name=["a"], position=[1.0]),
        "00010000"
        + "00" * 8
        + "010000000000000001000000020000006100000001000000000000000000f03f"
        + "00" * 8,
    ),
    (Bool(data=True), "0001000001"),
    (Empty(), "0001000000"),
    (String(data="hä"), "000100000400000068c3a400"),
    (Clock(clock=Time(sec=1, nanosec=2)), "000100000100000002000000"),
    (
        Float64MultiArray(data=[1.0, -2.5]),
        "0001000000000000000000000200000000000000000000000000f03f00000000000004c0",
    ),
]


@pytest.mark.parametrize(("message", "expected"), GOLDEN, ids=lambda value: type(value).__name__)
def test_golden_vectors(message, expected):
    assert serialize_message(message).hex() == expected
    assert deserialize_message(bytes.fromhex(expected), type(message)) == message


def rosbags_agrees(message):
    """Whether rosbags reads our bytes and writes the same again."""
    payload = serialize_message(message)
    name = f"{type(message).__module__.replace('.', '/')}/{type(message).__name__}"
    return bytes(STORE.serialize_cdr(STORE.deserialize_cdr(payload, name), name)) == payload


finite = st.floats(allow_nan=False)
texts = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=9)


@given(texts, st.lists(texts, max_size=3), st.lists(finite, max_size=5))
def test_any_joint_state_survives(frame, names, values):
    message = JointState(header=Header(frame_id=frame), name=names, position=values, effort=values)
    assert deserialize_message(serialize_message(message), JointState) == message
    assert rosbags_agrees(message)


@given(st.lists(texts, max_size=3), st.binary(max_size=5))
def test_any_nested_message_survives(labels, data):
    message = ByteMultiArray(data=[bytes([byte]) for byte in data])
    message.layout.dim = [MultiArrayDimension(label=label, size=1) for label in labels]
    assert deserialize_message(serialize_message(message), ByteMultiArray) == message
    assert rosbags_agrees(message)


def test_messages_of_many_shapes_agree_with_rosbags():
    event = ParameterEvent(node="/a")
    event.new_parameters = [
        Parameter("p", value=value).to_parameter_msg()
        for value in (True, 1, 2.5, "x", [True, False], [1, 2], [1.5], ["a", "bc"], [b"\x01"])
    ]
    status = DiagnosticStatus(level=b"\x02", name="n", values=[KeyValue(key="k", value="v")])
    pose = PoseWithCovarianceStamped()
    pose.pose.covariance[:] = np.arange(36.0)
    for message in (event, DiagnosticArray(status=[status, DiagnosticStatus()]), pose):
        assert rosbags_agrees(message)
        assert repr(deserialize_message(serialize_message(message), type(message))) == repr(message)


def test_an_array_that_was_received_can_be_changed():
    message = deserialize_message(serialize_message(JointState(position=[1.0])), JointState)
    message.position[0] = 2.0
    message.position.append(3.0)
    assert list(message.position) == [2.0, 3.0]


@pytest.mark.parametrize(
    "payload", [b"", b"\0\1\0\0", b"\0\1\0\0\xff\0\0\0ab", b"\0\0\0\0\0\0\0\1\0", b"\0\1\0\0\5"]
)
def test_bytes_that_are_no_message_are_an_error(payload):
    with pytest.raises(RuntimeError, match=r"failed to deserialize|not little-endian"):
        deserialize_message(payload, String)


@given(st.lists(st.sampled_from([0, 1, 2, 5, 77, 255]), max_size=100), st.sampled_from(TYPES))
def test_any_bytes_are_a_message_or_an_error(body, message_type):
    with contextlib.suppress(CdrError):
        deserialize_message(b"\0\1\0\0" + bytes(body), message_type)


@pytest.mark.parametrize("message_type", [ByteMultiArray, Float64MultiArray, UInt8MultiArray])
def test_a_count_beyond_the_end_of_the_payload_costs_no_memory(message_type):
    payload = b"\0\1\0\0" + struct.pack("<III", 0, 0, 10**6)
    with pytest.raises(CdrError):
        deserialize_message(payload, message_type)  # compiled outside of the measurement
    tracemalloc.start()
    try:
        with pytest.raises(CdrError, match="it ends too early"):
            deserialize_message(payload, message_type)
        assert tracemalloc.get_traced_memory()[1] < 100_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    "message", [String(data=5), JointState(name=[1]), Clock(clock=None), Time(sec=2**40)]
)
def test_a_field_of_the_wrong_type_is_an_error_when_it_is_sent(message):
    with pytest.raises(TypeError, match="has a wrong value"):
        serialize_message(message)


def test_float_sequences_are_copied_in_bulk(count_calls):
    def there_and_back(count):
        payload = serialize_message(Float64MultiArray(data=np.ones(count)))
        assert struct.unpack_from("<I", payload, 12) == (count,)
        return deserialize_message(payload, Float64MultiArray)

    there_and_back(1)  # compiled outside of the measurement
    few, many = (count_calls(lambda count=count: there_and_back(count)) for count in (10, 100_000))
    assert many < few + 1000, "whatever garbage is collected meanwhile"
    tracemalloc.start()
    try:
        there_and_back(100_000)
        # A float of Python is 24 bytes, and 8 more in a list.
        assert tracemalloc.get_traced_memory()[1] < 100_000 * 32
    finally:
        tracemalloc.stop()
