"""ROS arguments: remapping, parameters and what is left for the program."""

import pytest
import rclpy
from rclpy._rclpy_pybind11 import RCLError, RCLInvalidROSArgsError, UnknownROSArgsError
from rclpy.context import Context
from rclpy.node import Node
from rclpy.utilities import remove_ros_args
from std_msgs.msg import Float64
from std_srvs.srv import Trigger


def test_only_what_stands_between_the_marks_is_for_ros():
    words = ["p", "-p", "x:=1", "--ros-args", "-p", "a:=1", "--", "x", "--ros-args", "-r", "a:=b"]
    assert remove_ros_args(words) == ["p", "-p", "x:=1", "x"]


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


@pytest.mark.parametrize("arguments", [["-p", "a"], ["-r", "x"], ["--log-level", "loud"]])
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
