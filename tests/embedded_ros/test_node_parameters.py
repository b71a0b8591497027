"""Parameters of a node; texts are those of rclpy 7.1.3."""

import math

import pytest
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterEvent,
    ParameterType,
    ParameterValue,
    SetParametersResult,
)
from rclpy.exceptions import (
    InvalidParameterException,
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from rclpy.node import Node
from rclpy.parameter import Parameter


@pytest.fixture
def node(ros):
    return ros.create(Node, "n", given=7, group__x=1.0)


def test_a_declared_parameter_has_its_default_or_its_override(node):
    assert node.declare_parameter("p", 1).value == 1
    assert node.declare_parameter("given", 1).value == 7
    assert node.declare_parameter("group.x", 0.0, ignore_override=True).value == 0.0
    assert node.get_parameter("p").type_ is Parameter.Type.INTEGER


def test_declaring_twice_or_without_a_name_is_an_error(node):
    node.declare_parameter("p", 1)
    with pytest.raises(ParameterAlreadyDeclaredException, match=r"already declared: \['p'\]"):
        node.declare_parameter("p", 1)
    with pytest.raises(InvalidParameterException):
        node.declare_parameter("", 1)


def test_an_override_of_another_type_is_an_error(node):
    with pytest.raises(
        InvalidParameterTypeException,
        match="Trying to set parameter 'given' to '7' of type 'INTEGER', expecting type 'DOUBLE'",
    ):
        node.declare_parameter("given", 1.0)


def test_a_parameter_without_value_must_be_set_before_it_is_read(node):
    node.declare_parameter("p", Parameter.Type.DOUBLE)
    with pytest.raises(ParameterUninitializedException):
        node.get_parameter("p")
    assert node.get_parameter_or("p", Parameter("p", value=3.0)).value == 3.0
    node.set_parameters([Parameter("p", value=1.0)])
    assert node.get_parameter("p").value == 1.0


def test_undeclared_parameters_are_errors(node):
    with pytest.raises(ParameterNotDeclaredException, match=r"undeclared parameter\(s\): p"):
        node.get_parameter("p")
    with pytest.raises(ParameterNotDeclaredException):
        node.set_parameters([Parameter("p", value=1)])
    with pytest.raises(ParameterNotDeclaredException):
        node.undeclare_parameter("p")


def test_undeclared_parameters_can_be_allowed(ros):
    node = Node("n", context=ros.context, allow_undeclared_parameters=True)
    assert node.get_parameter("p").type_ is Parameter.Type.NOT_SET
    assert node.set_parameters([Parameter("p", value=1)])[0].successful
    assert node.set_parameters([Parameter("p", value="now a string")])[0].successful
    assert node.set_parameters([Parameter("p")])[0].successful
    assert not node.has_parameter("p")
    node.destroy_node()


def test_overrides_can_declare_themselves(ros):
    node = Node(
        "n",
        context=ros.context,
        parameter_overrides=[Parameter("p", value=3)],
        automatically_declare_parameters_from_overrides=True,
    )
    assert node.get_parameter("p").value == 3
    node.destroy_node()


def set_one(node, name, value):
    return node.set_parameters([Parameter(name, value=value)])[0]


DOUBLE_RANGE = ParameterDescriptor(
    floating_point_range=[FloatingPointRange(from_value=0.0, to_value=1.0, step=0.25)]
)
INTEGER_RANGE = ParameterDescriptor(integer_range=[IntegerRange(from_value=0, to_value=10, step=3)])


@pytest.mark.parametrize("value", [0.0, 1.0, 0.25, 1.0 + 1e-7])
def test_doubles_in_range(node, value):
    node.declare_parameter("p", 0.5, DOUBLE_RANGE)
    assert set_one(node, "p", value).successful


@pytest.mark.parametrize("value", [1.1, -1.0, math.inf, -math.inf, math.nan])
def test_doubles_out_of_range(node, value):
    node.declare_parameter("p", 0.5, DOUBLE_RANGE)
    result = set_one(node, "p", value)
    assert not result.successful
    assert result.reason == f"Parameter p out of range Min: 0.0, Max: 1.0, value: {value}"
    assert node.get_parameter("p").value == 0.5


def test_doubles_off_the_steps(node):
    node.declare_parameter("p", 0.5, DOUBLE_RANGE)
    assert "not close enough to a valid step" in set_one(node, "p", 0.3).reason


@pytest.mark.parametrize(("value", "fine"), [(0, 1), (10, 1), (3, 1), (4, 0), (11, 0), (-1, 0)])
def test_integers(node, value, fine):
    node.declare_parameter("p", 6, INTEGER_RANGE)
    assert set_one(node, "p", value).successful == bool(fine)


def test_a_default_out_of_range_is_an_error(node):
    with pytest.raises(InvalidParameterValueException, match="Parameter p out of range"):
        node.declare_parameter("p", 5.0, DOUBLE_RANGE)


def test_types_are_fixed_unless_dynamic(node):
    node.declare_parameter("p", 1)
    assert set_one(node, "p", "x").reason == (
        "Wrong parameter type, expected 'Type.INTEGER' got 'Type.STRING'"
    )
    assert set_one(node, "p", 1.0).reason.startswith("Wrong parameter type")
    assert set_one(node, "p", None).reason == "Static parameter cannot be undeclared"
    node.declare_parameter("q", 1, ParameterDescriptor(dynamic_typing=True))
    assert set_one(node, "q", "x").successful
    assert set_one(node, "q", None).successful
    assert not node.has_parameter("q")


def test_read_only_parameters_stay(node):
    node.declare_parameter("given", 1, ParameterDescriptor(read_only=True))
    assert set_one(node, "given", 2).reason == "Trying to set a read-only parameter: given."
    with pytest.raises(ParameterImmutableException):
        node.undeclare_parameter("given")
    assert node.get_parameter("given").value == 7


def test_all_or_none_are_set_atomically(node):
    node.declare_parameters("", [("a", 1), ("b", 3, INTEGER_RANGE)])
    result = node.set_parameters_atomically([Parameter("a", value=2), Parameter("b", value=99)])
    assert not result.successful
    assert node.get_parameter("a").value == 1


def test_callbacks_change_reject_and_react(node):
    node.declare_parameter("p", 1)
    seen = []

    def double(parameters):
        return [Parameter(item.name, value=2 * item.value) for item in parameters]

    def below_ten(parameters):
        fine = all(item.name != "p" or item.value < 10 for item in parameters)
        return SetParametersResult(successful=fine, reason="" if fine else "too much")

    node.add_pre_set_parameters_callback(double)
    node.add_on_set_parameters_callback(below_ten)
    node.add_post_set_parameters_callback(seen.extend)
    assert set_one(node, "p", 4).successful
    assert set_one(node, "p", 5).reason == "too much"
    assert node.get_parameter("p").value == 8
    assert [item.value for item in seen] == [8]
    node.remove_pre_set_parameters_callback(double)
    assert set_one(node, "p", 9).successful
    node.remove_on_set_parameters_callback(below_ten)
    with pytest.raises(ValueError, match="not in list"):
        node.remove_on_set_parameters_callback(below_ten)


def test_a_callback_that_rejects_a_default_makes_the_declaration_an_error(node):
    node.add_on_set_parameters_callback(
        lambda _: SetParametersResult(successful=False, reason="no way")
    )
    with pytest.raises(InvalidParameterValueException, match="Reason: no way: p"):
        node.declare_parameter("p", 1)


def test_listing_takes_prefix_and_depth(node):
    node.declare_parameters("grp", [("x", 1), ("y.z", 2.0)])
    assert node.list_parameters([], 1).names == ["use_sim_time", "start_type_description_service"]
    assert node.list_parameters(["grp"], 1).names == ["grp.x"]
    found = node.list_parameters(["grp"], 0)
    assert found.names == ["grp.x", "grp.y.z"]
    assert found.prefixes == ["grp", "grp.y"]
    assert sorted(node.get_parameters_by_prefix("grp")) == ["x", "y.z"]


def test_a_descriptor_can_be_replaced(node):
    node.declare_parameter("p", 5)
    narrow = ParameterDescriptor(
        type=ParameterType.PARAMETER_INTEGER,
        integer_range=[IntegerRange(from_value=0, to_value=3)],
    )
    other = ParameterValue(type=ParameterType.PARAMETER_INTEGER, integer_value=2)
    with pytest.raises(InvalidParameterValueException):
        node.set_descriptor("p", narrow)
    assert node.set_descriptor("p", narrow, other).integer_value == 2
    assert node.describe_parameter("p").integer_range[0].to_value == 3


def test_changes_are_published_from_the_first_declaration_on(ros):
    watcher = ros.create(Node, "watcher")
    events = []
    watcher.create_subscription(ParameterEvent, "/parameter_events", events.append, 100)
    node = ros.create(Node, "n")
    node.declare_parameter("p", 1)
    set_one(node, "p", 2)

    def of_node(kind):
        changes = [getattr(event, f"{kind}_parameters") for event in events if event.node == "/n"]
        return [item.name for change in changes for item in change]

    ros.spin_until(lambda: of_node("changed"))
    assert of_node("new") == ["use_sim_time", "start_type_description_service", "p"]
    assert of_node("changed") == ["p"]


@pytest.mark.parametrize("value", [[1, 2.0], {}, object()])
def test_no_type_fits_some_values(value):
    with pytest.raises(TypeError):
        Parameter("p", value=value)


def test_type_and_value_must_agree():
    with pytest.raises(ValueError, match="do not agree"):
        Parameter("p", Parameter.Type.DOUBLE, 1)


@pytest.mark.parametrize("value", [True, 1, 1.5, "x", [True], [1], [1.5], ["x"], [b"\x01"]])
def test_parameters_survive_their_messages(value):
    parameter = Parameter("p", value=value)
    again = Parameter.from_parameter_msg(parameter.to_parameter_msg())
    assert again.type_ is parameter.type_
    assert list(again.value) == value if isinstance(value, list) else again.value == value
