"""Requests that rclpy's own services answer with an exception out of the executor, or for ever."""

import pytest
from embedded_ros.message_classes import message_class
from embedded_ros.parameter_declaration import read_declarations
from embedded_ros.parameter_services import ANSWERS
from embedded_ros.parameter_store import ParameterStore
from hypothesis import given
from hypothesis import strategies as st
from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_event_handler import ParameterEventHandler

TYPE = "rcl_interfaces/srv/{}_{}"


def answer(store, name, **request):
    service, function = ANSWERS[name]
    response = message_class(TYPE.format(service, "Response"))()
    return function(store, message_class(TYPE.format(service, "Request"))(**request), response)


def test_a_type_that_does_not_exist_is_refused(ros):
    node = ros.create(Node, "n")
    node.declare_parameter("p", 1)
    bad = ParameterMsg(name="p", value=ParameterValue(type=200, integer_value=2))
    good = Parameter("p", value=3).to_parameter_msg()
    asking = ros.create(Node, "asking")
    one = asking.create_client(SetParameters, "/n/set_parameters")
    assert one.wait_for_service(20.0)
    first, second = ros.result(
        one.call_async(SetParameters.Request(parameters=[bad, good]))
    ).results
    assert not first.successful
    assert first.reason == "Parameter 'p' has a type that does not exist: 200"
    assert second.successful
    together = asking.create_client(SetParametersAtomically, "/n/set_parameters_atomically")
    assert together.wait_for_service(20.0)
    four = Parameter("p", value=4).to_parameter_msg()
    request = SetParametersAtomically.Request(parameters=[four, bad])
    assert not ros.result(together.call_async(request)).result.successful
    assert node.get_parameter("p").value == 3


NAMES = st.lists(st.sampled_from(["a", "a.b", "later", "loose", "", ".", "nothing"]), max_size=3)
MESSAGES = st.lists(
    st.builds(
        ParameterMsg,
        name=st.sampled_from(["a", "a.b", "later", "loose", "", "nothing"]),
        value=st.builds(
            ParameterValue,
            type=st.integers(0, 255),
            integer_value=st.integers(-(2**63), 2**63 - 1),
            double_value=st.floats(),
            byte_array_value=st.lists(st.binary(min_size=1, max_size=1), max_size=2),
        ),
    ),
    max_size=3,
)


@given(names=NAMES, depth=st.integers(0, 2**64 - 1), wanted=MESSAGES, is_open=st.booleans())
def test_whatever_is_asked_there_is_an_answer(names, depth, wanted, is_open):
    from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor

    store = ParameterStore(allow_undeclared=is_open)
    steps = [FloatingPointRange(from_value=-1e300, to_value=1e300, step=1e-300)]
    entries = [
        ("a", 1e300, ParameterDescriptor(floating_point_range=steps)),
        ("a.b", "x", ParameterDescriptor(read_only=True)),
        ("later", Parameter.Type.INTEGER),
        ("loose", 1, ParameterDescriptor(dynamic_typing=True)),
    ]
    store.declare(read_declarations("", entries))
    for name in ("get_parameters", "get_parameter_types", "describe_parameters"):
        answer(store, name, names=names)
    answer(store, "list_parameters", prefixes=names, depth=depth)
    assert len(answer(store, "set_parameters", parameters=wanted).results) == len(wanted)
    answer(store, "set_parameters_atomically", parameters=wanted)


def test_what_is_not_declared_has_a_type_or_is_refused():
    wanted = [Parameter("", value=1).to_parameter_msg()]
    closed, open_store = ParameterStore(), ParameterStore(allow_undeclared=True)
    (result,) = answer(closed, "set_parameters", parameters=wanted).results
    assert result.reason == "Invalid access to undeclared parameter(s): []"
    assert list(answer(open_store, "get_parameter_types", names=["new"]).types) == [0]


def test_a_callback_for_events_may_add_and_remove_callbacks(ros):
    node = ros.create(Node, "n")
    node.declare_parameter("p", 1)
    handler = ParameterEventHandler(ros.create(Node, "watcher"))
    calls = []

    def once(_):
        handler.remove_parameter_callback(handle)
        handler.add_parameter_event_callback(calls.append)
        calls.append("once")

    handle = handler.add_parameter_callback("p", "/n", once)
    for value, count in ((2, 1), (3, 2)):
        node.set_parameters([Parameter("p", value=value)])
        ros.spin_until(lambda count=count: len(calls) >= count)
    assert calls[0] == "once"
    assert calls.count("once") == 1
    with pytest.raises(RuntimeError, match="doesn't exist"):
        handler.remove_parameter_callback(handle)
