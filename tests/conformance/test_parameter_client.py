"""Parameter services, through their client."""

import pytest
from rcl_interfaces.msg import ParameterDescriptor, ParameterEvent
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient


@pytest.fixture
def parameters(ros, node):
    node.declare_parameters("", [("gain", 1.0), ("names", ["a", "b"])])
    client = AsyncParameterClient(ros.node("asking"), "/n")
    assert client.wait_for_services(5.0)
    return client


def test_remote_parameters_are_read(ros, parameters):
    values = ros.result(parameters.get_parameters(["gain", "names"])).values
    assert values[0].double_value == 1.0
    assert values[1].string_array_value == ["a", "b"]
    assert ros.result(parameters.get_parameters(["gain", "nothing"])).values == []
    assert list(ros.result(parameters.get_parameter_types(["gain"])).types) == [3]
    assert ros.result(parameters.describe_parameters(["gain"])).descriptors[0].name == "gain"
    names = ros.result(parameters.list_parameters()).result.names
    assert names == ["use_sim_time", "start_type_description_service", "gain", "names"]


def test_remote_parameters_are_set(ros, node, parameters):
    both = [Parameter("gain", value=2.5), Parameter("gain", value="x")]
    results = ros.result(parameters.set_parameters(both)).results
    assert [result.successful for result in results] == [True, False]
    assert "Wrong parameter type" in results[1].reason
    assert node.get_parameter("gain").value == 2.5
    result = ros.result(parameters.set_parameters_atomically(both)).result
    assert not result.successful
    missing = ros.result(parameters.set_parameters([Parameter("nothing", value=1)])).results[0]
    # The name is missing in rclpy's answer, too.
    assert missing.reason == "Invalid access to undeclared parameter(s): []"


def test_a_parameter_file_is_sent(ros, node, parameters, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("n: {ros__parameters: {gain: 4.5, names: [c]}}")
    ros.result(parameters.load_parameter_file(str(path)))
    assert node.get_parameter("gain").value == 4.5
    assert node.get_parameter("names").value == ["c"]


def test_arrays_arrive_as_arrays(ros, node, parameters):
    node.declare_parameter("values", [1.0])
    ros.result(parameters.set_parameters([Parameter("values", value=[1.5, 2.5])]))
    assert list(node.get_parameter("values").value) == [1.5, 2.5]


def test_values_of_every_type_survive(ros, node, parameters):
    values = {
        "bool": True,
        "integer": -3,
        "double": 2.5,
        "string": "ä",
        "bytes": [b"\x01", b"\xff"],
        "bools": [True, False],
        "integers": [1, -2],
        "doubles": [0.5, 1e300],
        "strings": ["", "a"],
    }
    for name, value in values.items():
        node.declare_parameter(name, Parameter.Type.from_parameter_value(value))
    request = [Parameter(name, value=value) for name, value in values.items()]
    results = ros.result(parameters.set_parameters(request)).results
    assert all(result.successful for result in results)
    for name, value in values.items():
        stored = node.get_parameter(name).value
        assert (list(stored) if isinstance(value, list) else stored) == value


def test_callbacks_get_the_future(ros, parameters):
    seen = []
    parameters.get_parameters(["gain"], callback=seen.append)
    ros.spin_until(lambda: seen)
    assert seen[0].result().values[0].double_value == 1.0


def test_names_are_listed_by_prefix_and_depth(ros, node, parameters):
    node.declare_parameters("group", [("x", 1), ("deep.y", 2)])
    result = ros.result(parameters.list_parameters(["group"], 1)).result
    assert result.names == ["group.x"]
    assert result.prefixes == ["group"]


def test_dynamic_parameters_are_deleted(ros, node, parameters):
    node.declare_parameter("volatile", 1, ParameterDescriptor(dynamic_typing=True))
    results = ros.result(parameters.delete_parameters(["volatile", "gain"])).results
    assert [result.successful for result in results] == [True, False]
    assert not node.has_parameter("volatile")


def test_a_file_is_set_atomically(ros, node, parameters, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("n: {ros__parameters: {gain: 4.5, names: 3}}")
    assert not ros.result(parameters.load_parameter_file_atomically(str(path))).result.successful
    assert node.get_parameter("gain").value == 1.0


def test_events_can_be_listened_to(ros, node, parameters):
    events = []
    parameters.on_parameter_event(events.append)
    node.set_parameters([Parameter("gain", value=3.0)])
    ros.spin_until(lambda: events)
    assert isinstance(events[0], ParameterEvent)
    assert events[0].changed_parameters[0].value.double_value == 3.0


def test_a_node_without_services(ros):
    ros.node("silent", start_parameter_services=False)
    client = AsyncParameterClient(ros.node("asking"), "silent")
    assert not client.wait_for_services(0.01)
    assert not client.services_are_ready()


def test_the_services_are_plain_services(ros, node):
    node.declare_parameter("gain", 1.5)
    client = ros.node("asking").create_client(GetParameters, "/n/get_parameters")
    assert client.wait_for_service(20.0)
    response = ros.result(client.call_async(GetParameters.Request(names=["gain"])))
    assert response.values[0].double_value == 1.5
    names = {name.rpartition("/")[2] for name, _ in node.get_service_names_and_types()}
    assert {
        "describe_parameters",
        "get_parameter_types",
        "get_parameters",
        "list_parameters",
        "set_parameters",
        "set_parameters_atomically",
    } <= names
