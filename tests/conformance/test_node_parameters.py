"""Parameters of a node; texts are those of rclpy 7.1.3."""

import pytest
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor, ParameterValue
from rclpy.exceptions import (
    InvalidHandle,
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
    return ros.node(
        "n",
        parameter_overrides=[Parameter("given", value=7), Parameter("group.x", value=1.0)],
    )


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


def test_listing_takes_prefix_and_depth(node):
    node.declare_parameters("grp", [("x", 1), ("y.z", 2.0)])
    assert node.list_parameters([], 1).names == ["use_sim_time", "start_type_description_service"]
    assert node.list_parameters(["grp"], 1).names == ["grp.x"]
    found = node.list_parameters(["grp"], 0)
    assert found.names == ["grp.x", "grp.y.z"]
    assert found.prefixes == ["grp", "grp.y"]
    assert sorted(node.get_parameters_by_prefix("grp")) == ["x", "y.z"]


def test_parameters_are_declared_together(node):
    declared = node.declare_parameters(
        "group", [("a", 1), ("b", "x", ParameterDescriptor(description="text"))]
    )
    assert [parameter.name for parameter in declared] == ["group.a", "group.b"]
    assert node.describe_parameter("group.b").description == "text"
    assert [parameter.value for parameter in node.get_parameters(["group.b", "group.a"])] == [
        "x",
        1,
    ]


@pytest.mark.parametrize("entry", [(), ("a", 1, ParameterDescriptor(), 4), (5, 1), ("a", 1, 2)])
def test_malformed_declarations_are_errors(node, entry):
    with pytest.raises(TypeError):
        node.declare_parameters("", [entry])


def test_a_name_alone_is_dynamic_and_deprecated(node):
    with pytest.warns(UserWarning, match="only providing its name is deprecated"):
        parameter = node.declare_parameter("p")
    assert parameter.type_ is Parameter.Type.NOT_SET
    assert node.describe_parameter("p").dynamic_typing
    assert set_one(node, "p", 1).successful
    assert set_one(node, "p", "x").successful


def test_a_static_type_needs_a_value_or_a_type(node):
    with pytest.raises(ValueError, match="statically typed"):
        node.declare_parameter("p", None, ParameterDescriptor())
    with pytest.raises(ValueError, match="NOT_SET"):
        node.declare_parameter("p", Parameter.Type.NOT_SET)
    with pytest.raises(ValueError, match="dynamic_typing"):
        node.declare_parameter(
            "p", Parameter.Type.INTEGER, ParameterDescriptor(dynamic_typing=True)
        )
    with pytest.raises(TypeError):
        node.declare_parameter("p", object())


def test_a_parameter_can_be_undeclared(node):
    node.declare_parameter("p", 1)
    node.undeclare_parameter("p")
    assert not node.has_parameter("p")
    assert node.declare_parameter("p", "x").value == "x"


def test_types_and_descriptors_can_be_asked_for(node):
    node.declare_parameter("p", 1.5)
    assert node.get_parameter_type("p") == Parameter.Type.DOUBLE.value
    assert node.get_parameter_types(["p", "use_sim_time"]) == [3, 1]
    described = node.describe_parameters(["p"])[0]
    assert (described.name, described.type, described.read_only) == ("p", 3, False)
    for ask in (node.get_parameter_type, node.describe_parameter):
        with pytest.raises(ParameterNotDeclaredException):
            ask("nothing")
    with pytest.raises(TypeError):
        node.get_parameters([1])


def test_what_is_set_must_be_parameters(node):
    with pytest.raises((TypeError, AttributeError)):
        node.set_parameters([("p", 1)])


def test_setting_stops_at_an_undeclared_parameter(node):
    node.declare_parameter("p", 1)
    with pytest.raises(ParameterNotDeclaredException):
        node.set_parameters([Parameter("p", value=2), Parameter("nothing", value=1)])
    assert node.get_parameter("p").value == 2


def test_an_alternative_stands_in(node):
    assert node.get_parameter_or("p").type_ is Parameter.Type.NOT_SET
    node.declare_parameter("p", 1)
    assert node.get_parameter_or("p", Parameter("p", value=5)).value == 1


def test_listing_checks_its_arguments(node):
    for prefixes, depth, error in (
        (("a",), 1, TypeError),
        ([1], 1, TypeError),
        ([], -1, ValueError),
    ):
        with pytest.raises(error):
            node.list_parameters(prefixes, depth)


def test_names_may_begin_with_a_dot(node):
    node.declare_parameters("", [(".f", 1), ("c..d", 1), ("e.", 1)])
    found = node.list_parameters([], 0)
    assert found.prefixes == ["", "c.", "e"]
    assert node.list_parameters([""], 0).names == [".f"]
    assert node.list_parameters(["c"], 1).names == []
    assert node.list_parameters(["c"], 2).names == ["c..d"]


def test_what_went_before_an_error_stays_declared(node):
    small = ParameterDescriptor(integer_range=[IntegerRange(from_value=0, to_value=3)])
    with pytest.raises(InvalidParameterValueException):
        node.declare_parameters("", [("a", 1), ("b", 5, small), ("c", 1)])
    assert [node.has_parameter(name) for name in "abc"] == [True, False, False]
    with pytest.raises(TypeError):
        node.declare_parameters("", [("d", 1), (5, 1)])
    assert not node.has_parameter("d")
    with pytest.raises(ParameterAlreadyDeclaredException, match=r"\['a', 'use_sim_time'\]"):
        node.declare_parameters("", [("e", 1), ("a", 1), ("use_sim_time", True)])
    assert not node.has_parameter("e")


def test_parameters_that_share_a_descriptor_share_its_name_and_type(node):
    shared = ParameterDescriptor(description="both")
    node.declare_parameter("a", 1, shared)
    node.declare_parameter("b", "x", shared)
    assert node.describe_parameter("a") is shared
    assert (shared.name, shared.type) == ("b", Parameter.Type.STRING.value)
    assert not set_one(node, "a", 2).successful


def test_of_two_declarations_of_a_name_the_second_counts(node):
    declared = node.declare_parameters("", [("a", 1), ("a", 2)])
    assert [parameter.value for parameter in declared] == [2, 2]


def test_a_destroyed_node_keeps_its_parameters_as_they_are(ros):
    node = Node("n", context=ros.context)
    node.declare_parameter("p", 1)
    node.destroy_node()
    assert node.get_parameter("p").value == 1
    with pytest.raises(InvalidHandle):
        set_one(node, "p", 2)
    with pytest.raises(InvalidHandle):
        node.declare_parameter("q", 1)


def test_a_descriptor_is_replaced_without_a_word(node):
    node.declare_parameter("p", 5)
    node.add_on_set_parameters_callback(lambda _: pytest.fail("asked"))
    alternative = ParameterValue(type=2, integer_value=2)
    small = ParameterDescriptor(type=2, integer_range=[IntegerRange(from_value=0, to_value=3)])
    assert node.set_descriptor("p", small, alternative).integer_value == 2
    with pytest.raises(InvalidParameterValueException, match=r"expected 'Type\.NOT_SET'"):
        node.set_descriptor("p", ParameterDescriptor())
