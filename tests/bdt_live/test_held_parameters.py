"""Parameters of nodes whose events are older than the last minute."""

from rcl_interfaces.msg import Parameter, ParameterEvent
from rclpy.parameter import Parameter as NamedValue
from rclpy.serialization import deserialize_message, serialize_message

from bdt_bags.writing.topic_metadata import SerializedMessage
from bdt_live.held_parameters import HeldParameters


def parameters(**values):
    return [NamedValue(name, value=value).to_parameter_msg() for name, value in values.items()]


def message(node, received, **lists):
    event = ParameterEvent(node=node, **lists)
    event.stamp.sec = received
    return SerializedMessage(3, received, received, serialize_message(event))


def held(*messages):
    keeper = HeldParameters()
    for each in messages:
        keeper.take(each)
    return {
        event.node: {
            each.name: NamedValue.from_parameter_msg(each).value for each in event.new_parameters
        }
        for event in (deserialize_message(one.data, ParameterEvent) for one in keeper.messages())
        if not event.changed_parameters
    }


def test_nothing_was_told():
    assert HeldParameters().messages() == []


def test_the_last_value_of_each_parameter_of_each_node_holds():
    assert held(
        message("/plant", 1, new_parameters=parameters(pitch=0.1)),
        message("/controller", 2, new_parameters=parameters(dead_zone_tolerance=0.0, enabled=True)),
        message("/controller", 5, changed_parameters=parameters(dead_zone_tolerance=2e-5)),
    ) == {
        "/plant": {"pitch": 0.1},
        "/controller": {"dead_zone_tolerance": 2e-5, "enabled": True},
    }


def test_a_parameter_that_is_gone_holds_no_longer():
    gone = [Parameter(name="pitch")]
    first = message("/plant", 1, new_parameters=parameters(pitch=0.1, gap=0.2))
    assert held(first, message("/plant", 2, deleted_parameters=gone)) == {"/plant": {"gap": 0.2}}


def test_the_topic_and_the_stamp_are_those_of_the_last_event():
    keeper = HeldParameters()
    for second in (1, 4):
        keeper.take(message("/plant", second, new_parameters=parameters(pitch=0.1)))
    (one,) = keeper.messages()
    assert (one.topic, one.received) == (3, 4)
    assert deserialize_message(one.data, ParameterEvent).stamp.sec == 4
