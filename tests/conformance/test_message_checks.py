"""Checks of message fields: on request they say what rosidl says."""

from array import array

import numpy as np
import pytest
from geometry_msgs.msg import PoseWithCovariance
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor, ParameterValue
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Byte, Float32, Float64, Int8, String, UInt16
from std_srvs.srv import SetBool


def test_what_is_no_sequence_of_numbers_is_rejected_at_once():
    with pytest.raises(TypeError):
        JointState(position="abc")
    with pytest.raises(TypeError):
        JointState(position=["a"])


@pytest.mark.parametrize(
    ("message_type", "values", "text"),
    [
        (JointState, {"nonsense": 1}, "Invalid arguments passed to constructor: nonsense"),
        (Int8, {"data": 300}, "The 'data' field must be an integer in [-128, 127]"),
        (UInt16, {"data": -3}, "The 'data' field must be an unsigned integer in [0, 65535]"),
        (String, {"data": 3}, "The 'data' field must be of type 'str'"),
        (Float64, {"data": 1}, "The 'data' field must be of type 'float'"),
        (
            Float32,
            {"data": 1e39},
            "The 'data' field must be a float in [-3.402823466e+38, 3.402823466e+38]",
        ),
        (
            Byte,
            {"data": b"ab"},
            "The 'data' field must be of type 'bytes' or 'ByteString' with length 1",
        ),
        (JointState, {"header": 3}, "The 'header' field must be a sub message of type 'Header'"),
        (
            JointState,
            {"name": "abc"},
            "The 'name' field must be a set or sequence and each value of type 'str'",
        ),
        (
            ParameterDescriptor,
            {"integer_range": [IntegerRange(), IntegerRange()]},
            (
                "The 'integer_range' field must be a set or sequence with length <= 1 and each "
                "value of type 'IntegerRange'"
            ),
        ),
    ],
)
def test_checks_on_request_say_what_rosidl_says(message_type, values, text):
    with pytest.raises(AssertionError) as error:
        message_type(check_fields=True, **values)
    assert str(error.value) == text


@pytest.mark.parametrize(
    ("message_type", "field", "value"),
    [
        (Bool, "data", 1),
        (Int8, "data", 1.0),
        (Int8, "data", -129),
        (UInt16, "data", 65536),
        (Float32, "data", 4e38),
        (Float64, "data", "1.0"),
        (String, "data", b"x"),
        (JointState, "position", array("f")),
        (JointState, "position", {"a": 1}),
        (JointState, "name", [1]),
        (PoseWithCovariance, "covariance", np.zeros(35)),
        (PoseWithCovariance, "covariance", np.zeros(36, np.float32)),
        (ParameterValue, "byte_array_value", [1]),
        (SetBool.Request, "data", "yes"),
    ],
)
def test_a_checked_message_checks_every_assignment(message_type, field, value):
    message = message_type(check_fields=True)
    before = getattr(message, field)
    with pytest.raises(AssertionError, match=f"'{field}'"):
        setattr(message, field, value)
    assert np.array_equal(getattr(message, field), before)


@pytest.mark.parametrize(
    ("message_type", "field", "value"),
    [
        (Int8, "data", -128),
        (UInt16, "data", 65535),
        (Float32, "data", float("inf")),
        (Float64, "data", float("nan")),
        (JointState, "position", [1.0]),
        (JointState, "position", (1.0, 2.0)),
        (JointState, "position", array("d", [1.0])),
        (JointState, "name", ("a", "b")),
        (PoseWithCovariance, "covariance", np.zeros(36)),
        (ParameterDescriptor, "integer_range", [IntegerRange()]),
    ],
)
def test_what_fits_passes_the_checks(message_type, field, value):
    message = message_type(check_fields=True)
    setattr(message, field, value)
    assert len(str(getattr(message, field))) > 0


def test_a_message_does_not_check_unless_asked():
    message = String()
    message.data = 3
    assert message.data == 3
    message = Int8(data=300)
    assert message.data == 300
