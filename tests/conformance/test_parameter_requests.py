"""What the parameter services of a node answer, whatever they are asked."""

import math

import pytest
from rcl_interfaces.msg import (
    FloatingPointRange,
    ParameterDescriptor,
    ParameterEvent,
    ParameterType,
    ParameterValue,
)
from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_parameters

UNDECLARED = "Invalid access to undeclared parameter(s): []"


@pytest.fixture
def ask(ros):
    """Return a function that asks a node's service and gives what the response holds."""
    asking = ros.node("asking")

    def ask(service, node="n", **request):
        snake = "".join(f"_{c.lower()}" if c.isupper() else c for c in service.__name__)
        client = asking.create_client(
            service, f"/{node}/{snake.lstrip('_')}", qos_profile=qos_profile_parameters
        )
        assert client.wait_for_service(20.0)
        response = ros.result(client.call_async(service.Request(**request)))
        asking.destroy_client(client)
        (field,) = response.get_fields_and_field_types()
        return getattr(response, field)

    return ask


@pytest.fixture
def node(ros):
    node = ros.node("n")
    unit = [FloatingPointRange(from_value=0.0, to_value=1.0)]
    node.declare_parameters(
        "",
        [
            ("gain", 0.5, ParameterDescriptor(floating_point_range=unit)),
            ("any", 0.5),
            ("count", 3),
            ("fixed", "x", ParameterDescriptor(read_only=True)),
            ("loose", 1, ParameterDescriptor(dynamic_typing=True)),
            ("later", Parameter.Type.INTEGER),
            ("list", [1]),
            ("group.x", 1),
            ("group.y.z", 1),
            ("grouped", 1),
        ],
    )
    return node


@pytest.fixture
def events(ros, node):
    """Events of the node from now on, as names of new, changed and deleted parameters."""
    seen = []

    def keep(event):
        parts = event.new_parameters, event.changed_parameters, event.deleted_parameters
        if event.node == "/n":
            seen.append(tuple([parameter.name for parameter in part] for part in parts))

    ros.node("watcher").create_subscription(ParameterEvent, "/parameter_events", keep, 100)
    return seen


def message(name, value):
    return Parameter(name, value=value).to_parameter_msg()


@pytest.mark.usefixtures("node")
@pytest.mark.parametrize(
    ("prefixes", "depth", "names", "found_prefixes"),
    [
        (["group"], 0, ["group.x", "group.y.z"], ["group", "group.y"]),
        (["group"], 1, ["group.x"], ["group"]),
        (["group"], 2, ["group.x", "group.y.z"], ["group", "group.y"]),
        (["group"], 2**64 - 1, ["group.x", "group.y.z"], ["group", "group.y"]),
        (["group.y", "group"], 1, ["group.x", "group.y.z"], ["group", "group.y"]),
        (["group", "group"], 1, ["group.x"], ["group"]),
        (["group.x"], 1, ["group.x"], ["group"]),
        (["count"], 1, ["count"], []),
        (["grou"], 0, [], []),
        (["group."], 0, [], []),
        ([""], 0, [], []),
        (["."], 0, [], []),
        (["nothing", "count"], 0, ["count"], []),
    ],
)
def test_names_are_listed_below_prefixes(ask, prefixes, depth, names, found_prefixes):
    result = ask(ListParameters, prefixes=prefixes, depth=depth)
    assert (result.names, result.prefixes) == (names, found_prefixes)


@pytest.mark.usefixtures("node")
def test_without_prefixes_all_names_are_listed(ask):
    everything = ask(ListParameters)
    assert {"use_sim_time", "count", "group.y.z"} <= set(everything.names)
    top = ask(ListParameters, depth=1).names
    assert "count" in top
    assert not any("." in name for name in top)
    assert "group.y.z" not in ask(ListParameters, depth=2).names


@pytest.mark.usefixtures("node")
@pytest.mark.parametrize("names", [["nothing"], [""], ["count", "nothing"], ["\U0001f916"], []])
@pytest.mark.parametrize("service", [GetParameters, GetParameterTypes, DescribeParameters])
def test_one_undeclared_name_empties_the_answer(ask, service, names):
    assert len(ask(service, names=names)) == 0


@pytest.mark.usefixtures("node")
def test_a_name_may_be_asked_for_twice(ask):
    assert [value.integer_value for value in ask(GetParameters, names=["count"] * 2)] == [3, 3]


@pytest.mark.usefixtures("node")
def test_a_parameter_without_value_has_a_descriptor_and_no_value(ask):
    assert ask(GetParameters, names=["later"]) == []
    assert list(ask(GetParameterTypes, names=["later"])) == [ParameterType.PARAMETER_NOT_SET]
    (descriptor,) = ask(DescribeParameters, names=["later"])
    assert descriptor.type == ParameterType.PARAMETER_INTEGER


@pytest.mark.usefixtures("node")
def test_descriptors_tell_what_was_declared(ask):
    gain, fixed, loose = ask(DescribeParameters, names=["gain", "fixed", "loose"])
    assert (gain.name, gain.type) == ("gain", ParameterType.PARAMETER_DOUBLE)
    assert gain.floating_point_range[0].to_value == 1.0
    assert fixed.read_only
    assert loose.dynamic_typing


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("nothing", 1, UNDECLARED),
        ("nothing", None, UNDECLARED),
        ("count", 1.0, "Wrong parameter type, expected 'Type.INTEGER' got 'Type.DOUBLE'"),
        ("count", None, "Static parameter cannot be undeclared"),
        ("fixed", "y", "Trying to set a read-only parameter: fixed."),
        ("fixed", "x", "Trying to set a read-only parameter: fixed."),
        ("gain", math.nan, "Parameter gain out of range Min: 0.0, Max: 1.0, value: nan"),
        ("gain", math.inf, "Parameter gain out of range Min: 0.0, Max: 1.0, value: inf"),
        ("list", [1.0], "Wrong parameter type, expected 'Type.INTEGER_ARRAY' got "),
        ("list", 1, "Wrong parameter type, expected 'Type.INTEGER_ARRAY' got "),
        ("later", "x", "Wrong parameter type, expected 'Type.INTEGER' got 'Type.STRING'"),
    ],
)
def test_what_may_not_be_is_refused_with_a_reason(ask, node, events, name, value, reason):
    before = node.get_parameter_or(name).value
    (one,) = ask(SetParameters, parameters=[message(name, value)])
    together = ask(SetParametersAtomically, parameters=[message(name, value)])
    for result in (one, together):
        assert not result.successful
        assert result.reason.startswith(reason)
    assert node.get_parameter_or(name).value == before
    assert events == []


def test_not_a_number_is_a_value_where_no_range_forbids_it(ask, node):
    (result,) = ask(SetParameters, parameters=[message("any", math.nan)])
    assert result.successful
    assert math.isnan(node.get_parameter("any").value)


def test_an_empty_array_has_the_type_of_its_message(ask, node):
    empty = ParameterValue(type=ParameterType.PARAMETER_INTEGER_ARRAY)
    (result,) = ask(SetParameters, parameters=[ParameterMsg(name="list", value=empty)])
    assert result.successful
    assert len(node.get_parameter("list").value) == 0
    other = ParameterValue(type=ParameterType.PARAMETER_DOUBLE_ARRAY)
    (result,) = ask(SetParameters, parameters=[ParameterMsg(name="list", value=other)])
    assert "got 'Type.DOUBLE_ARRAY'" in result.reason


def test_only_the_field_of_the_type_counts(ask, node):
    value = ParameterValue(type=2, integer_value=7, double_value=1.5, string_value="x")
    (result,) = ask(SetParameters, parameters=[ParameterMsg(name="count", value=value)])
    assert result.successful
    assert node.get_parameter("count").value == 7


def test_one_by_one_what_is_fine_is_set(ask, node, ros, events):
    wanted = [message("count", 4), message("nothing", 1), message("gain", 2.0), message("any", 2.0)]
    results = ask(SetParameters, parameters=wanted)
    assert [result.successful for result in results] == [True, False, False, True]
    assert [node.get_parameter(name).value for name in ("count", "gain", "any")] == [4, 0.5, 2.0]
    ros.spin_until(lambda: len(events) == 2)
    assert events == [([], ["count"], []), ([], ["any"], [])]


def test_together_one_that_may_not_be_holds_up_all(ask, node, ros, events):
    wanted = [message("count", 4), message("loose", None), message("gain", 2.0)]
    assert not ask(SetParametersAtomically, parameters=wanted).successful
    assert node.get_parameter("count").value == 3
    assert node.has_parameter("loose")
    node.set_parameters([Parameter("any", value=1.0)])
    ros.spin_until(lambda: events)
    assert events == [([], ["any"], [])]


def test_together_there_is_one_event(ask, node, ros, events):
    wanted = [message("later", 1), message("count", 4), message("loose", None), message("any", 2.0)]
    assert ask(SetParametersAtomically, parameters=wanted).successful
    assert not node.has_parameter("loose")
    ros.spin_until(lambda: events)
    assert events == [(["later"], ["count", "any"], ["loose"])]


def test_the_last_one_of_a_name_counts(ask, node):
    wanted = [message("count", 4), message("count", 5)]
    assert ask(SetParametersAtomically, parameters=wanted).successful
    assert node.get_parameter("count").value == 5


@pytest.mark.usefixtures("node")
def test_nothing_can_be_set(ask):
    assert ask(SetParameters, parameters=[]) == []
    assert ask(SetParametersAtomically, parameters=[]).successful


def test_a_dynamic_parameter_takes_any_type(ask, node):
    for value in ("x", 1.5, [True], 1):
        assert ask(SetParametersAtomically, parameters=[message("loose", value)]).successful
        kept = node.get_parameter("loose").value
        assert (list(kept) if isinstance(value, list) else kept) == value
        (descriptor,) = ask(DescribeParameters, names=["loose"])
        assert descriptor.type == Parameter.Type.from_parameter_value(value).value


def test_a_node_may_take_what_it_did_not_declare(ask, ros):
    open_node = ros.node("open", allow_undeclared_parameters=True)
    assert [value.type for value in ask(GetParameters, node="open", names=["new"])] == [0]
    (result,) = ask(SetParameters, node="open", parameters=[message("new", 1)])
    assert result.successful
    assert open_node.get_parameter("new").value == 1
    (descriptor,) = ask(DescribeParameters, node="open", names=["new"])
    assert descriptor.dynamic_typing
    (result,) = ask(SetParameters, node="open", parameters=[message("new", None)])
    assert result.successful
    assert not open_node.has_parameter("new")
