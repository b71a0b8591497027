"""Names: what is valid, how it expands. Texts and positions are those of Jazzy."""

import pytest
from rclpy._rclpy_pybind11 import RCLError
from rclpy.exceptions import (
    InvalidNamespaceException,
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
)
from rclpy.expand_topic_name import expand_topic_name
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden
from rclpy.validate_full_topic_name import validate_full_topic_name
from rclpy.validate_namespace import validate_namespace
from rclpy.validate_node_name import validate_node_name
from rclpy.validate_topic_name import validate_topic_name
from std_msgs.msg import Float64


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("chatter", "/ns/chatter"),
        ("/chatter", "/chatter"),
        ("~", "/ns/node"),
        ("~/private", "/ns/node/private"),
        ("{node}/x", "/ns/node/x"),
    ],
)
def test_expansion(name, expected):
    assert expand_topic_name(name, "node", "/ns") == expected


@pytest.mark.parametrize(
    ("name", "node", "namespace", "text"),
    [
        ("a b", "node", "/", "topic name 'a b' is invalid: topic name must not contain"),
        ("", "node", "/", "must not be empty"),
        ("{what}", "node", "/", "unknown substitution: {what}"),
        ("x", "a b", "/", "node name 'a b' is invalid"),
        ("x", "node", "ns", "node namespace 'ns' is invalid: namespace must be absolute"),
    ],
)
def test_names_that_do_not_expand(name, node, namespace, text):
    with pytest.raises(ValueError) as error:  # noqa: PT011 - the text is looked at below
        expand_topic_name(name, node, namespace)
    assert text in str(error.value)


def test_expansion_in_the_root_namespace():
    assert expand_topic_name("chatter", "node", "/") == "/chatter"
    assert expand_topic_name("~/x", "node", "/") == "/node/x"


@pytest.mark.parametrize(
    ("validate", "name", "error", "text"),
    [
        (validate_node_name, "", InvalidNodeNameException, "must not be empty"),
        (validate_node_name, "1a", InvalidNodeNameException, "must not start with a number"),
        (validate_node_name, "a/b", InvalidNodeNameException, "characters other than"),
        (validate_node_name, "x" * 256, InvalidNodeNameException, "should not exceed '255'"),
        (validate_namespace, "a", InvalidNamespaceException, "must be absolute"),
        (validate_namespace, "/a/", InvalidNamespaceException, "must not end with"),
        (validate_namespace, "/1a", InvalidNamespaceException, "starts with a number"),
        (validate_topic_name, "", InvalidTopicNameException, "must not be empty string"),
        (validate_topic_name, "a/", InvalidTopicNameException, "must not end with a forward slash"),
        (validate_topic_name, "a~", InvalidTopicNameException, "tilde '~' unless"),
        (validate_topic_name, "~ab", InvalidTopicNameException, "not followed by a forward slash"),
        (validate_topic_name, "~{node}", InvalidTopicNameException, "not followed by a forward"),
        (validate_topic_name, "{x", InvalidTopicNameException, "unmatched"),
        (validate_topic_name, "{1x}", InvalidTopicNameException, "must not start with a number"),
        (validate_full_topic_name, "a", InvalidTopicNameException, "must be absolute"),
        (validate_full_topic_name, "/a//b", InvalidTopicNameException, "repeated '/'"),
    ],
)
def test_invalid_names(validate, name, error, text):
    with pytest.raises(error, match=text.replace("'", ".")):
        validate(name)


@pytest.mark.parametrize(
    ("name", "place"),
    [
        ("a b", 1),
        ("{a", 0),
        ("a/1", 2),
        ("a~", 1),
        ("~ab/1", 1),
        ("a/", 1),
        ("\u00e9/", 2),
        ("{1}", 1),
    ],
)
def test_the_error_points_at_the_character(name, place):
    with pytest.raises(InvalidTopicNameException) as error:
        validate_topic_name(name)
    assert str(error.value).splitlines()[1:] == [f"  '{name}'", f"   {' ' * place}^"]


def test_a_service_name_has_an_error_of_its_own():
    with pytest.raises(InvalidServiceNameException, match="Invalid service name"):
        validate_topic_name("a b", is_service=True)


@pytest.mark.parametrize("name", ["/", "/a", "/a/b_1"])
def test_valid_namespaces(name):
    assert validate_namespace(name) is True


def test_hidden_names():
    assert topic_or_service_is_hidden("/a/_b")
    assert not topic_or_service_is_hidden("/a/b_")


def test_topics_expand_in_the_nodes_namespace(ros):
    node = ros.node("n", namespace="/ns")
    names = {"x": "/ns/x", "/x": "/x", "~/x": "/ns/n/x", "{node}/x": "/ns/n/x", "{ns}/x": "/ns/x"}
    for given, expected in names.items():
        assert node.resolve_topic_name(given) == expected
        assert node.resolve_service_name(given) == expected
        assert node.create_publisher(Float64, given, 1).topic_name == expected
    with pytest.raises(RCLError, match="failed to resolve name: topic name must not contain"):
        node.resolve_topic_name("a b")


@pytest.mark.parametrize(
    ("namespace", "expected"), [(None, "/"), ("", "/"), ("a", "/a"), ("/a/b", "/a/b")]
)
def test_namespaces_are_absolute(ros, namespace, expected):
    node = ros.node("n", namespace=namespace)
    assert node.get_namespace() == expected
    assert node.get_name() == "n"
    assert node.get_fully_qualified_name() == f"{expected.rstrip('/')}/n"


def test_nodes_with_invalid_names_are_not_made(ros):
    with pytest.raises(InvalidNodeNameException):
        ros.node("a b")
    with pytest.raises(InvalidNamespaceException):
        ros.node("n", namespace="a b")
