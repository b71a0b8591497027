"""``/parameter_events`` and the handler of such events."""

import pytest
from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.msg import ParameterDescriptor, ParameterEvent
from rclpy.parameter import Parameter
from rclpy.parameter_event_handler import ParameterEventHandler


def set_one(node, name, value):
    return node.set_parameters([Parameter(name, value=value)])[0]


def test_changes_are_published_from_the_first_declaration_on(ros):
    watcher = ros.node("watcher")
    events = []
    watcher.create_subscription(ParameterEvent, "/parameter_events", events.append, 100)
    node = ros.node("n")
    node.declare_parameter("p", 1)
    set_one(node, "p", 2)

    def of_node(kind):
        changes = [getattr(event, f"{kind}_parameters") for event in events if event.node == "/n"]
        return [item.name for change in changes for item in change]

    ros.spin_until(lambda: of_node("changed"))
    assert of_node("new") == ["use_sim_time", "start_type_description_service", "p"]
    assert of_node("changed") == ["p"]


def test_deleted_parameters_are_told_of(ros, node):
    events = []
    node.create_subscription(ParameterEvent, "/parameter_events", events.append, 100)
    node.declare_parameter("p", 1, ParameterDescriptor(dynamic_typing=True))
    set_one(node, "p", None)
    ros.spin_until(lambda: any(event.deleted_parameters for event in events))
    assert events[-1].deleted_parameters[0].name == "p"
    assert events[-1].stamp.sec > 0


@pytest.fixture
def handler(ros, node):
    node.declare_parameters("", [("p", 1), ("q", 1)])
    # A node of its own: nothing of the declarations above is there to be heard.
    handler = ParameterEventHandler(ros.node("watcher", namespace="/far"))
    yield handler
    handler.destroy()


def test_a_handler_calls_back_for_a_parameter_of_a_node(ros, node, handler):
    seen = []
    handle = handler.add_parameter_callback("p", "/n", seen.append)
    assert (handle.parameter_name, handle.node_name) == ("p", "/n")
    other = []
    handler.add_parameter_callback("p", "n", other.append)  # that is /far/n
    handler.add_parameter_callback("p", "/nobody", other.append)
    set_one(node, "q", 2)
    set_one(node, "p", 3)
    ros.spin_until(lambda: seen)
    assert isinstance(seen[0], ParameterMsg)
    assert (seen[0].name, seen[0].value.integer_value) == ("p", 3)
    handler.remove_parameter_callback(handle)
    with pytest.raises(RuntimeError, match="doesn't exist"):
        handler.remove_parameter_callback(handle)
    set_one(node, "p", 4)
    ros.spin_for(0.02)
    assert len(seen) == 1
    assert other == []


def test_a_handler_calls_back_for_events(ros, node, handler):
    order = []
    handler.add_parameter_event_callback(lambda _: order.append("first"))
    handle = handler.add_parameter_event_callback(order.append)
    handler.add_parameter_callback("p", "/n", lambda _: order.append("parameter"))
    set_one(node, "p", 3)
    ros.spin_until(lambda: len(order) == 3)
    # Those for a parameter come before those for events, the newest before the others.
    assert order[0] == "parameter"
    assert isinstance(order[1], ParameterEvent)
    assert order[2] == "first"
    handler.remove_parameter_event_callback(handle)
    with pytest.raises(RuntimeError, match="doesn't exist"):
        handler.remove_parameter_event_callback(handle)


def test_a_handler_means_its_own_node_by_default(ros, handler):
    own = handler.node
    own.declare_parameter("p", 1)
    seen = []
    handler.add_parameter_callback("p", "", seen.append)
    handler.add_parameter_callback("p", "watcher", seen.append)
    set_one(own, "p", 5)
    ros.spin_until(lambda: len(seen) == 2)


def test_parameters_are_found_in_an_event():
    event = ParameterEvent(node="/n")
    event.new_parameters = [Parameter("a", value=1).to_parameter_msg()]
    event.changed_parameters = [Parameter("b", value=2).to_parameter_msg()]
    find = ParameterEventHandler.get_parameter_from_event
    assert find(event, "b", "/n").value.integer_value == 2
    assert find(event, "c", "/n") is None
    assert find(event, "b", "/other") is None
    found = ParameterEventHandler.get_parameters_from_event(event)
    assert [parameter.name for parameter in found] == ["a", "b"]
