"""Parameters by themselves: types, values, messages, texts and files."""

from array import array

import pytest
from rcl_interfaces.msg import ParameterValue
from rclpy.exceptions import InvalidParameterException
from rclpy.parameter import (
    Parameter,
    get_parameter_value,
    parameter_dict_from_yaml_file,
    parameter_value_to_python,
)
from rclpy.validate_parameter_name import validate_parameter_name

VALUES = [
    (None, Parameter.Type.NOT_SET),
    (True, Parameter.Type.BOOL),
    (1, Parameter.Type.INTEGER),
    (1.5, Parameter.Type.DOUBLE),
    ("x", Parameter.Type.STRING),
    ([b"\x01"], Parameter.Type.BYTE_ARRAY),
    ([True], Parameter.Type.BOOL_ARRAY),
    ([1], Parameter.Type.INTEGER_ARRAY),
    ([1.5], Parameter.Type.DOUBLE_ARRAY),
    (["x"], Parameter.Type.STRING_ARRAY),
    ((1, 2), Parameter.Type.INTEGER_ARRAY),
    (array("d", [1.5]), Parameter.Type.DOUBLE_ARRAY),
    ([], Parameter.Type.BYTE_ARRAY),
]


@pytest.mark.parametrize(("value", "type_"), VALUES)
def test_a_value_has_a_type(value, type_):
    parameter = Parameter("p", value=value)
    assert parameter.type_ is type_
    assert Parameter.Type.from_parameter_value(value) is type_
    assert type_.check(value)
    assert (parameter.name, parameter.value) == ("p", value)


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


def test_a_parameter_can_be_given_a_type():
    assert Parameter("p", Parameter.Type.STRING_ARRAY, []).type_ is Parameter.Type.STRING_ARRAY
    with pytest.raises(TypeError, match="type must be an instance"):
        Parameter("p", "STRING", "x")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("true", True),
        ("5", 5),
        ("2.5", 2.5),
        ("abc", "abc"),
        ("'5'", "5"),
        ("[1, 2]", [1, 2]),
        ("[a, b]", ["a", "b"]),
        ("[1, a]", "[1, a]"),
        ("", ""),
    ],
)
def test_texts_are_values(text, value):
    assert parameter_value_to_python(get_parameter_value(text)) == value


def test_a_value_of_no_type_is_an_error():
    assert parameter_value_to_python(ParameterValue()) is None
    with pytest.raises(RuntimeError, match="unexpected parameter type"):
        parameter_value_to_python(ParameterValue(type=99))


FILE = """
/**: {ros__parameters: {everywhere: 1}}
n:
  ros__parameters:
    gain: 2.5
    group: {x: [1, 2], y: {z: text}}
other: {ros__parameters: {gain: 1.0}}
"""


def test_files_hold_parameters(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(FILE)
    found = parameter_dict_from_yaml_file(str(path), target_nodes=["n"])
    assert found.keys() == {"gain", "group.x", "group.y.z"}
    assert found["group.y.z"].value.string_value == "text"
    assert list(found["group.x"].value.integer_array_value) == [1, 2]
    everywhere = parameter_dict_from_yaml_file(str(path), True, target_nodes=["n"])
    assert everywhere["everywhere"].value.integer_value == 1
    with pytest.raises(RuntimeError, match="does not contain parameters for nobody"):
        parameter_dict_from_yaml_file(str(path), target_nodes=["nobody"])


def test_parameter_names_must_not_be_empty():
    assert validate_parameter_name("a.b")
    with pytest.raises(InvalidParameterException):
        validate_parameter_name("")
