"""Command-line arguments mean what they mean to rcl."""

import subprocess
import sys

import pytest
import rclpy
from embedded_ros.ros_arguments import parse_arguments
from rclpy._rclpy_pybind11 import RCLError, RCLInvalidROSArgsError
from rclpy.context import Context
from rclpy.node import Node


def parameters(*arguments, node="n", namespace="/ns"):
    return parse_arguments(["program", "--ros-args", *arguments]).parameters_of(node, namespace)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("-3", -3),
        ("010", 8),
        ("0x10", 16),
        ("1.0", 1.0),
        ("1.", 1.0),
        ("1e3", 1000.0),
        ("-.inf", float("-inf")),
        ("yes", True),
        ("off", False),
        ("'yes'", "yes"),
        ('"5"', "5"),
        ("!!str 5", "5"),
        ("1.0.0", "1.0.0"),
        ("[1, 2]", [1, 2]),
        ("[1.0, 2.5]", [1.0, 2.5]),
        ("[a, b]", ["a", "b"]),
        ("[true, no]", [True, False]),
        ("99999999999999999999", 99999999999999999999.0),
    ],
)
def test_values_have_the_types_of_rcl(text, value):
    found = parameters("-p", f"a:={text}")["a"]
    assert found == value
    assert type(found) is type(value)


def test_not_a_number_is_a_number():
    assert str(parameters("-p", "a:=.nan")["a"]) == "nan"


def test_an_empty_list_is_no_value_as_its_type_is_unknown():
    assert parameters("-p", "a:=[]") == {"a": None}


def test_rules_for_a_node_are_for_that_node():
    rules = ("-p", "n:a:=1", "-p", "other:b:=2", "-p", "c:=3")
    assert parameters(*rules, namespace="/") == {"a": 1, "c": 3}
    assert parameters(*rules) == {"c": 3}


def test_the_last_rule_wins():
    assert parameters("-p", "a:=1", "-p", "a:=2") == {"a": 2}


FILE = """
/**:
  ros__parameters:
    everywhere: 1
    group: {x: 1.0, y: [a, b]}
n:
  ros__parameters: {by_name: true}
/ns/n:
  ros__parameters: {by_full_name: 2}
ns:
  n:
    ros__parameters: {by_nesting: 3}
/*/n:
  ros__parameters: {by_star: 4}
/ns/other:
  ros__parameters: {not_mine: 5}
"""


def test_parameter_files(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text(FILE)
    everywhere = {"everywhere": 1, "group.x": 1.0, "group.y": ["a", "b"]}
    in_namespace = {"by_full_name": 2, "by_nesting": 3, "by_star": 4}
    assert parameters("--params-file", str(path)) == everywhere | in_namespace
    in_root = parameters("--params-file", str(path), namespace="/")
    assert in_root == everywhere | {"by_name": True}


def test_a_rule_after_a_file_overrides_it(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("/**: {ros__parameters: {a: 1}}")
    assert parameters("--params-file", str(path), "-p", "a:=2") == {"a": 2}
    assert parameters("-p", "a:=2", "--params-file", str(path)) == {"a": 1}


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("/**: {ros__parameters: {a: [1, 2.0]}}", "Sequence should be of same type"),
        ("/**: {ros__parameters: {a: }}", "No value at line 1"),
        ("/**: {ros__parameters: 3}", "must be a mapping"),
        ("ros__parameters: {a: 1}", "below no node name"),
        ("n: {a: 1}", "'a' stands outside of 'ros__parameters'"),
        ("a: [", "is not YAML"),
        ("- a", "must be a mapping"),
        ("/**: {ros__parameters: {a: &x 1, b: *x}}", "an alias has no meaning"),
        ("/ns/n*: {ros__parameters: {a: 1}}", "'/ns/n*' names no node"),
        ("ns: {/n: {ros__parameters: {a: 1}}}", "'/n' names no node"),
    ],
)
def test_a_bad_file_is_named_with_the_reason(tmp_path, content, text):
    path = tmp_path / "p.yaml"
    path.write_text(content)
    with pytest.raises(RCLInvalidROSArgsError) as error:
        parameters("--params-file", str(path))
    assert text in str(error.value)
    assert str(path) in str(error.value)


@pytest.mark.parametrize(
    "arguments",
    [
        ["-p"],
        ["-p", "a"],
        ["-p", ":=1"],
        ["-p", "1e:=3"],
        ["-p", "a:="],
        ["-p", "a:={b: 1}"],
        ["-p", "/ns/n:a:=1"],
        ["-p", "*:a:=1"],
        ["-p", "a..b:=1"],
        ["-p", "__a:=1"],
        ["-r", "x"],
        ["-r", "a:=b c"],
        ["-r", "__ns:=relative"],
        ["--log-level", "loud"],
        ["--params-file", "/nowhere.yaml"],
    ],
)
def test_malformed_arguments_are_errors_of_init_and_of_nodes(arguments, ros):
    with pytest.raises(RCLError, match="failed to initialize rcl: Couldn't parse"):
        rclpy.init(args=["--ros-args", *arguments], context=Context())
    with pytest.raises(RCLInvalidROSArgsError, match="Failed to parse ROS arguments"):
        Node("n", context=ros.context, cli_args=["--ros-args", *arguments])


def loads_yaml(*statements):
    """Whether a new process has loaded PyYAML after these statements."""
    program = "\n".join(["import rclpy, sys", *statements, "print('yaml' in sys.modules)"])
    done = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True, timeout=60
    )
    return {"True\n": True, "False\n": False}[done.stdout]


def test_without_parameters_nothing_waits_for_a_reader_of_yaml():
    assert not loads_yaml()
    assert not loads_yaml(
        "import rclpy.parameter_client",
        "from rclpy.parameter import Parameter",
        "rclpy.init(args=['program', 'word:=other', '--ros-args', '-r', '__node:=n'])",
        "node = rclpy.create_node('m', parameter_overrides=[Parameter('a', value=1)])",
        "assert node.declare_parameter('a', 0).value == 1",
        "node.destroy_node()",
        "rclpy.shutdown()",
    )


@pytest.mark.parametrize("arguments", [["-p", "a:=1"], ["--params-file", "FILE"]])
def test_parameters_are_read_with_one(tmp_path, arguments):
    path = tmp_path / "p.yaml"
    path.write_text("/**: {ros__parameters: {a: 1}}")
    words = ["--ros-args", *(str(path) if word == "FILE" else word for word in arguments)]
    assert loads_yaml(f"rclpy.init(args={words!r})", "rclpy.shutdown()")
