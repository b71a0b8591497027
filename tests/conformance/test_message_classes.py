"""Message classes behave like rosidl's, also where that surprises (verified against Jazzy)."""

import copy
import pickle
from array import array

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseWithCovariance, Quaternion
from rcl_interfaces.msg import Log, ParameterDescriptor, ParameterType
from sensor_msgs.msg import JointState, NavSatStatus
from std_msgs.msg import Byte, ByteMultiArray, Empty, Header, String
from std_srvs.srv import SetBool, Trigger


def test_fields_have_the_zero_of_their_type_or_the_default_of_the_definition():
    state = JointState()
    assert state.header == Header()
    assert state.name == []
    assert state.position == array("d")
    assert Quaternion().w == 1.0
    assert NavSatStatus().status == -2
    assert Byte().data == b"\0"
    assert PoseWithCovariance().covariance.shape == (36,)


def test_each_message_has_values_of_its_own():
    first, second = JointState(), JointState()
    first.name.append("a")
    first.header.frame_id = "base"
    assert second.name == []
    assert second.header.frame_id == ""


def test_arguments_are_by_name_only_and_unknown_ones_are_ignored():
    with pytest.raises(TypeError, match=r"JointState.__init__\(\) takes 1 positional"):
        JointState([1.0])
    assert JointState(nonsense=1) == JointState()


@pytest.mark.parametrize(
    "values",
    [[1.0, 2.0], (1, 2), array("d", [1, 2]), np.array([1.0, 2.0]), np.array([1, 2], np.int32)],
)
def test_a_float_sequence_becomes_an_array(values):
    message = JointState(position=values)
    assert message.position == array("d", [1.0, 2.0])
    message.position = values
    assert message.position.typecode == "d"


def test_a_fixed_size_array_is_a_numpy_array_of_that_size():
    with pytest.raises(AssertionError):
        PoseWithCovariance(covariance=[1.0])
    assert PoseWithCovariance(covariance=range(36)).covariance.dtype == np.float64


def test_without_checks_a_wrong_type_goes_unnoticed_until_it_is_sent():
    assert String(data=3).data == 3


def test_equality_compares_fields():
    assert JointState(name=["a"]) == JointState(name=["a"])
    assert JointState(name=["a"]) != JointState()
    assert JointState() != String()
    with pytest.raises(TypeError, match="unhashable"):
        hash(JointState())


def test_numpy_fields_differ_only_if_every_element_does():
    # A known fault of rosidl, kept: code must not behave differently here.
    other = PoseWithCovariance()
    other.covariance[0] = 1.0
    assert PoseWithCovariance() == other
    other.covariance[:] = 1.0
    assert PoseWithCovariance() != other


def test_repr_names_package_fields_and_values():
    assert repr(JointState(name=["a"], position=[1.0])) == (
        "sensor_msgs.msg.JointState(header=std_msgs.msg.Header("
        "stamp=builtin_interfaces.msg.Time(sec=0, nanosec=0), frame_id=''), "
        "name=['a'], position=[1.0], velocity=[], effort=[])"
    )
    assert repr(Trigger.Request()) == "std_srvs.srv.Trigger_Request()"


def test_fields_and_types_are_told_in_idl():
    assert JointState.get_fields_and_field_types() == {
        "header": "std_msgs/Header",
        "name": "sequence<string>",
        "position": "sequence<double>",
        "velocity": "sequence<double>",
        "effort": "sequence<double>",
    }
    types = ParameterDescriptor.get_fields_and_field_types()
    assert types["integer_range"] == "sequence<rcl_interfaces/IntegerRange, 1>"
    assert types["read_only"] == "boolean"
    assert PoseWithCovariance.get_fields_and_field_types()["covariance"] == "double[36]"
    assert JointState.__slots__[-1] == "_check_fields"


def test_constants_are_attributes_of_class_and_message():
    assert ParameterType.PARAMETER_DOUBLE == 3
    assert DiagnosticStatus().WARN == b"\x01"


def test_messages_are_copied_and_pickled():
    message = JointState(name=["a"], position=[1.0])
    assert copy.deepcopy(message) == message
    assert pickle.loads(pickle.dumps(message)) == message  # noqa: S301 - our own bytes
    request = SetBool.Request(data=True)
    assert pickle.loads(pickle.dumps(request)) == request  # noqa: S301 - our own bytes


def test_what_does_not_exist_cannot_be_imported():
    with pytest.raises(ImportError, match="cannot import name 'Nothing'"):
        from std_msgs.msg import Nothing  # noqa: F401


def test_import_star_brings_all_messages():
    names = {}
    exec("from std_srvs.srv import *", names)  # noqa: S102 - that is what is tested
    assert {"Empty", "SetBool", "Trigger"} <= names.keys()


def test_slot_types_tell_what_the_slots_hold():
    header, name, position, *_ = JointState.SLOT_TYPES
    assert len(JointState.SLOT_TYPES) == len(JointState.get_fields_and_field_types())
    assert header.namespaced_name() == ("std_msgs", "msg", "Header")
    assert (header.namespaces, header.name) == (["std_msgs", "msg"], "Header")
    assert type(name.value_type).__name__ == "UnboundedString"
    assert type(position).__name__ == "UnboundedSequence"
    assert position.value_type.typename == "double"
    assert not position.has_maximum_size()
    covariance = PoseWithCovariance.SLOT_TYPES[1]
    assert (type(covariance).__name__, covariance.size) == ("Array", 36)
    limits = ParameterDescriptor.SLOT_TYPES[-1]
    assert (type(limits).__name__, limits.maximum_size) == ("BoundedSequence", 1)
    assert limits.value_type.name == "IntegerRange"
    assert ByteMultiArray.SLOT_TYPES[1].value_type.typename == "octet"
    assert SetBool.Request.SLOT_TYPES[0].typename == "boolean"


def test_empty_messages_have_no_fields():
    assert Empty() == Empty()
    assert repr(Empty()) == "std_msgs.msg.Empty()"
    assert Empty.get_fields_and_field_types() == {}
    assert Empty.__slots__ == ["_check_fields"]


def test_services_hold_request_and_response():
    assert SetBool.Request().data is False
    assert SetBool.Response.get_fields_and_field_types() == {
        "success": "boolean",
        "message": "string",
    }
    with pytest.raises(NotImplementedError):
        SetBool()


def test_fields_cannot_be_made_up():
    with pytest.raises(AttributeError):
        String().nonsense = 1


def test_constants_cannot_be_set():
    assert Log.INFO == 20
    with pytest.raises(AttributeError):
        Log().INFO = 5
    with pytest.raises(AttributeError):
        Log.INFO = 5


def test_what_the_fields_are_told_is_a_copy():
    String.get_fields_and_field_types()["data"] = "wrong"
    assert String.get_fields_and_field_types() == {"data": "string"}
