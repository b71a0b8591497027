"""The namespace of a loop, which moves the clock as well."""

import pytest
from rclpy.exceptions import InvalidNamespaceException
from rclpy.validate_namespace import validate_namespace

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.loop_namespace import full_namespace, namespace_arguments


@pytest.mark.parametrize("name", [None, "", "/"])
def test_without_a_name_nothing_moves(name):
    assert full_namespace(name) == ""
    assert namespace_arguments("") == []


@pytest.mark.parametrize("name", ["left", "/left", "left/", "a/b_2", "_x"])
def test_what_ros_takes_for_a_namespace_is_one(name):
    namespace = full_namespace(name)
    validate_namespace(namespace)
    assert namespace == f"/{name.strip('/')}"
    assert namespace_arguments(namespace) == [
        "-r",
        f"__ns:={namespace}",
        "-r",
        "/clock:=clock",
    ]


@pytest.mark.parametrize("name", ["a b", "2nd", "a//b", "a/2", "ä", "a-b", "~a", "a\n"])
def test_what_ros_does_not_take_is_refused_in_one_line(name):
    with pytest.raises(InvalidNamespaceException):
        validate_namespace(f"/{name}")
    with pytest.raises(BadInputError, match="must consist of letters"):
        full_namespace(name)
