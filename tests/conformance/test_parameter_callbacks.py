"""Callbacks before, on and after the setting of parameters."""

import pytest
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.exceptions import InvalidParameterValueException
from rclpy.parameter import Parameter


def set_one(node, name, value):
    return node.set_parameters([Parameter(name, value=value)])[0]


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


def test_the_newest_callback_is_called_first(node):
    node.declare_parameter("p", 1)
    order = []
    for name in ("first", "second"):
        node.add_post_set_parameters_callback(lambda _, name=name: order.append(name))

        def accept(_, name=name):
            order.append(f"on {name}")
            return SetParametersResult(successful=True)

        node.add_on_set_parameters_callback(accept)
    set_one(node, "p", 2)
    assert order == ["on second", "on first", "second", "first"]


def test_a_rejection_calls_nobody_else(node):
    node.declare_parameter("p", 1)
    calls = []
    node.add_on_set_parameters_callback(lambda _: calls.append("not asked"))
    node.add_on_set_parameters_callback(lambda _: SetParametersResult(successful=False))
    node.add_post_set_parameters_callback(calls.append)
    assert not set_one(node, "p", 2).successful
    assert calls == []


def test_callbacks_are_not_asked_of_what_the_descriptor_rejects(node):
    node.declare_parameter("p", 1, ParameterDescriptor(read_only=True))
    calls = []
    node.add_on_set_parameters_callback(calls.append)
    assert not set_one(node, "p", 2).successful
    assert calls == []


def test_a_declaration_asks_the_callbacks(node):
    seen = []
    node.add_on_set_parameters_callback(
        lambda parameters: (seen.extend(parameters), SetParametersResult(successful=True))[1]
    )
    node.add_post_set_parameters_callback(seen.extend)
    node.declare_parameter("p", 1)
    assert [(parameter.name, parameter.value) for parameter in seen] == [("p", 1)] * 2


def test_a_callback_before_may_remove_everything(node):
    node.declare_parameter("p", 1)
    node.add_pre_set_parameters_callback(lambda _: [])
    result = set_one(node, "p", 2)
    assert not result.successful
    assert "parameter list cannot be empty" in result.reason


def test_a_callback_after_may_set_another_parameter(node):
    node.declare_parameters("", [("p", 1), ("q", 1)])

    def follow(parameters):
        if parameters[0].name == "p":
            set_one(node, "q", parameters[0].value)

    node.add_post_set_parameters_callback(follow)
    set_one(node, "p", 5)
    assert node.get_parameter("q").value == 5


def test_what_a_callback_raises_comes_out(node):
    node.declare_parameter("p", 1)

    def boom(_):
        raise ValueError("boom")

    node.add_on_set_parameters_callback(boom)
    with pytest.raises(ValueError, match="boom"):
        set_one(node, "p", 2)
    assert node.get_parameter("p").value == 1


def test_callbacks_before_all_get_what_was_asked_for(node):
    node.declare_parameters("", [("a", 1), ("b", 1)])
    seen = []

    def add_b(parameters):
        seen.append(("first", [parameter.value for parameter in parameters]))
        return [*parameters, Parameter("b", value=5)]

    def add_one(parameters):
        seen.append(("second", [parameter.value for parameter in parameters]))
        return [Parameter(parameter.name, value=parameter.value + 1) for parameter in parameters]

    node.add_pre_set_parameters_callback(add_b)
    node.add_pre_set_parameters_callback(add_one)
    assert set_one(node, "a", 2).successful
    assert seen == [("second", [2]), ("first", [2])]
    assert [node.get_parameter(name).value for name in "ab"] == [2, 5]


def test_callbacks_before_are_not_asked_of_a_declaration(node):
    node.add_pre_set_parameters_callback(lambda _: [])
    assert node.declare_parameter("p", 1).value == 1


def test_a_callback_before_may_put_a_declared_name_for_another(node):
    node.declare_parameter("p", 1)
    node.add_pre_set_parameters_callback(lambda _: [Parameter("p", value=9)])
    assert set_one(node, "undeclared", 1).successful
    assert node.get_parameter("p").value == 9


def test_callbacks_on_set_see_the_old_value_and_those_after_the_new_one(node):
    node.declare_parameter("p", 1)
    seen = []

    def judge(_):
        seen.append(node.get_parameter("p").value)
        return SetParametersResult(successful=True, reason="not told")

    node.add_on_set_parameters_callback(judge)
    node.add_post_set_parameters_callback(lambda _: seen.append(node.get_parameter("p").value))
    assert set_one(node, "p", 2).reason == ""
    assert seen == [1, 2]


def test_a_callback_may_be_added_twice(node):
    node.declare_parameter("p", 1)
    calls = []
    for _ in range(2):
        node.add_post_set_parameters_callback(calls.append)
    set_one(node, "p", 2)
    node.remove_post_set_parameters_callback(calls.append)
    set_one(node, "p", 3)
    assert len(calls) == 3


def test_what_a_callback_after_raises_comes_out_and_the_value_stays(node):
    node.declare_parameter("p", 1)

    def boom(_):
        raise ValueError("boom")

    node.add_post_set_parameters_callback(boom)
    with pytest.raises(ValueError, match="boom"):
        set_one(node, "p", 2)
    assert node.get_parameter("p").value == 2
