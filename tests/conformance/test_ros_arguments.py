"""ROS arguments: remapping, parameters and what is left for the program."""

import math

import pytest
import rclpy
from rclpy._rclpy_pybind11 import RCLError, RCLInvalidROSArgsError, UnknownROSArgsError
from rclpy.context import Context
from rclpy.exceptions import ParameterUninitializedException
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.utilities import remove_ros_args
from std_msgs.msg import Float64
from std_srvs.srv import Trigger


def test_only_what_stands_between_the_marks_is_for_ros():
    words = ["p", "-p", "x:=1", "--ros-args", "-p", "a:=1", "--", "x", "--ros-args", "-r", "a:=b"]
    assert remove_ros_args(words) == ["p", "-p", "x:=1", "x"]


def test_a_bare_remap_rule_is_for_ros_too(ros):
    assert remove_ros_args(["p", "a:=b", "__ns:=/x", "a:=1"]) == ["p", "a:=1"]
    context = Context()
    rclpy.init(args=["p", "a:=b", "__node:=renamed"], context=context)
    node = Node("n", context=context)
    assert (node.get_name(), node.resolve_topic_name("a")) == ("renamed", "/b")
    node.destroy_node()
    context.shutdown()


def test_unknown_arguments_are_listed():
    with pytest.raises(UnknownROSArgsError, match=r"\['--what', 'ever'\]"):
        rclpy.init(args=["--ros-args", "--what", "ever"], context=Context())


@pytest.fixture
def remapped():
    context = Context()
    rules = ["foo:=bar", "/absolute:=/elsewhere", "~/private:=public", "taken:__ns:=/there"]
    rules += ["given:__node:=taken", "rosservice://trig:=girt", "taken:mine:=yours"]
    rclpy.init(context=context, args=["--ros-args", *(w for rule in rules for w in ("-r", rule))])
    node = Node("given", context=context, namespace="here")
    yield node
    node.destroy_node()
    context.try_shutdown()


def test_nodes_are_renamed_and_names_remapped(remapped):
    assert remapped.get_fully_qualified_name() == "/there/taken"
    assert remapped.get_logger().name == "there.taken"
    assert remapped.resolve_topic_name("foo") == "/there/bar"
    assert remapped.resolve_topic_name("/absolute") == "/elsewhere"
    assert remapped.resolve_topic_name("~/private") == "/there/public"
    assert remapped.resolve_topic_name("foo", only_expand=True) == "/there/foo"
    assert remapped.resolve_topic_name("mine") == "/there/yours"
    assert remapped.resolve_service_name("trig") == "/there/girt"
    assert remapped.resolve_topic_name("trig") == "/there/trig"


def test_arguments_of_a_node_come_before_those_of_the_process(ros):
    context = Context()
    rclpy.init(context=context, args=["--ros-args", "-p", "a:=1", "-p", "b:=1", "-r", "x:=y"])
    own = ["--ros-args", "-p", "a:=2", "-r", "x:=z"]
    node = Node("n", context=context, cli_args=own)
    assert node.declare_parameter("a", 0).value == 2
    assert node.declare_parameter("b", 0).value == 1
    assert node.resolve_topic_name("x") == "/z"
    alone = Node("m", context=context, use_global_arguments=False)
    assert alone.declare_parameter("a", 0).value == 0
    for each in (node, alone):
        each.destroy_node()
    context.shutdown()


def test_entities_take_remapped_names(remapped):
    publisher = remapped.create_publisher(Float64, "foo", 1)
    assert (publisher.topic, publisher.topic_name) == ("foo", "/there/bar")
    assert remapped.create_subscription(Float64, "foo", print, 1).topic_name == "/there/bar"
    assert remapped.create_service(Trigger, "trig", print).service_name == "/there/girt"
    assert remapped.create_client(Trigger, "trig").service_name == "/there/girt"


PARAMETERS = """
 a a:= :=1 1a:=1 __a:=1 .a:=1 a.:=1 a..b:=1 a.1:=1 a-b:=1 a*:=1 {node}:=1 n::a:=1 :a:=1 n:m:a:=1
 /n:a:=1 /ns/n:a:=1 *:a:=1 /**:a:=1 ~:a:=1 a:={} a:=[1,b] a:=[true,1] a:=*x a:=[
"""
REMAPS = """
 a a:= :=b a:=b:=c 1a:=b a:=1b a/:=b a:=b/ a//b:=c a:=b//c {node}:=b a:={node} {what}:=b ~:=b a:=~
 *:=b **:=b /*:=b a*:=b a:=* __x:=y a:=__b /n:a:=b ns/n:a:=b a:=b:c rosaction://a:=b ~a:=b
 a:=rostopic://b rostopic://n:a:=b rostopic://__ns:=/x __ns:=x __ns:=~/x __node:=1x __node:=a/b
 __node:={x}
"""
LEVELS = ("loud", "10", "", "warning", ":=info", "a:=", "a:=b:=info")
MALFORMED = [
    *(["-p", rule] for rule in PARAMETERS.split()),
    *(["-r", rule] for rule in REMAPS.split()),
    *(
        ["--log-level", text]
        for text in ("loud", "10", "", "warning", ":=info", "a:=", "a:=b:=info")
    ),
]


@pytest.mark.parametrize("arguments", MALFORMED, ids=" ".join)
def test_malformed_arguments_are_errors(ros, arguments):
    with pytest.raises(RCLError):
        rclpy.init(args=["--ros-args", *arguments], context=Context())
    with pytest.raises(RCLInvalidROSArgsError, match="Failed to parse ROS arguments"):
        Node("n", context=ros.context, cli_args=["--ros-args", *arguments])


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("1.0", 1.0),
        ("1e3", 1000.0),
        ("yes", True),
        ("'yes'", "yes"),
        ("[1, 2]", [1, 2]),
        ("[1.5, 2.0]", [1.5, 2.0]),
        ("[a, b]", ["a", "b"]),
        ("[true, no]", [True, False]),
        ("010", 8),
        ("0x10", 16),
        ("-9223372036854775809", -9223372036854775809.0),
        ("0x8000000000000000", 2.0**63),
        ("0x1.8p1", 3.0),
        ("1e400", "1e400"),
        ("1e-400", "1e-400"),
        ("-.inf", -math.inf),
        ("-.nan", "-.nan"),
        ("!!float 1", 1),
        ("!!str 1", "1"),
        ("tRUE", "tRUE"),
        ("2024-01-01", "2024-01-01"),
        ("1_000", "1_000"),
        ("b:=c", "b:=c"),
    ],
)
def test_parameters_have_the_types_of_yaml(ros, text, value):
    node = ros.node(
        "n",
        cli_args=["--ros-args", "-p", f"a:={text}"],
        automatically_declare_parameters_from_overrides=True,
    )
    found = node.get_parameter("a").value
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize("name", ["a", "_a", "a__", "a.b.c", "a/b", "/a", "a/", "A1"])
def test_names_of_parameters(ros, name):
    node = ros.node("n", cli_args=["--ros-args", "-p", f"{name}:=1"])
    assert node.declare_parameter(name, 0).value == 1


def test_an_empty_list_is_a_value_that_is_not_set(ros):
    node = ros.node("n", cli_args=["--ros-args", "-p", "a:=[]"])
    assert node.declare_parameter("a", [1.0]).type_ is Parameter.Type.NOT_SET
    with pytest.raises(ParameterUninitializedException):
        node.get_parameter("a")


@pytest.mark.parametrize("enclave", ["x", "", "/x/", "/1", "/x y"])
def test_an_enclave_is_an_absolute_name(enclave):
    with pytest.raises(RCLError, match="Enclave name is not valid: 'context name "):
        rclpy.init(args=["--ros-args", "--enclave", enclave], context=Context())


@pytest.mark.parametrize(
    "content",
    [
        "n:",
        "n: 1",
        "- a",
        "a: [",
        "n: {a: 1}",
        "n: {ros__parameters: }",
        "n: {ros__parameters: 1}",
        "ros__parameters: {a: 1}",
        "ns: {/n: {ros__parameters: {a: 1}}}",
        "/ns/n*: {ros__parameters: {a: 1}}",
        "/**: {ros__parameters: {a: }}",
        "/**: {ros__parameters: {a: [1, a]}}",
        "/**: {ros__parameters: {'': 1}}",
        "/**: {ros__parameters: {a: &x 1, b: *x}}",
    ],
)
def test_malformed_parameter_files_are_errors(content, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(content)
    with pytest.raises(RCLError, match="Couldn't parse params file"):
        rclpy.init(args=["--ros-args", "--params-file", str(path)], context=Context())


FILE = """
/**: {ros__parameters: {everywhere: 1, group: {x: 1.0, y: [a, b]}}}
/ns/n: {ros__parameters: {by_full_name: 2}}
n: {ros__parameters: {not_mine: true}}
ns: {n: {ros__parameters: {by_nesting: 3}}}
"""


def test_parameter_files_are_read(ros, tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(FILE)
    node = ros.node(
        "n",
        namespace="ns",
        cli_args=["--ros-args", "--params-file", str(path), "-p", "everywhere:=5"],
        automatically_declare_parameters_from_overrides=True,
    )
    found = {name: value.value for name, value in node.get_parameters_by_prefix("").items()}
    assert (
        found.items()
        >= {
            "everywhere": 5,
            "group.x": 1.0,
            "group.y": ["a", "b"],
            "by_full_name": 2,
            "by_nesting": 3,
        }.items()
    )
    assert "not_mine" not in found


@pytest.mark.parametrize(
    "words", [["n", "\udcff"], ["n", "--ros-args", "-r", "a:=\udcff"], ["--ros-args", "\udcff"]]
)
def test_arguments_are_utf_8(words):
    with pytest.raises(UnicodeEncodeError, match="surrogates not allowed"):
        rclpy.init(args=words, context=Context())
    with pytest.raises(UnicodeEncodeError, match="surrogates not allowed"):
        remove_ros_args(words)


def test_arguments_of_a_node_are_utf_8(ros):
    with pytest.raises(RuntimeError):
        ros.node("n", cli_args=["--ros-args", "-p", "a:=\udcff"])
