"""What descriptors let pass; texts are those of rclpy 7.1.3."""

import math

import pytest
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    ParameterType,
    ParameterValue,
)
from rclpy.exceptions import InvalidParameterValueException, ParameterNotDeclaredException
from rclpy.parameter import Parameter


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


def test_all_or_none_are_set_atomically(node):
    node.declare_parameters("", [("a", 1), ("b", 3, INTEGER_RANGE)])
    result = node.set_parameters_atomically([Parameter("a", value=2), Parameter("b", value=99)])
    assert not result.successful
    assert node.get_parameter("a").value == 1


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
    with pytest.raises(ParameterNotDeclaredException):
        node.set_descriptor("nothing", narrow)


def test_integers_out_of_range_are_explained(node):
    node.declare_parameter("p", 6, INTEGER_RANGE)
    assert set_one(node, "p", 11).reason == ("Parameter p out of range. Min: 0, Max: 10, value: 11")
    assert "is not a valid step" in set_one(node, "p", 4).reason
