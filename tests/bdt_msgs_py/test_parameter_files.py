"""Which sections of a parameter file are for a node, and what is said of a file without any."""

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_files import is_for, sections, unused_files

NODES = ("/twin", "/left/twin", "/a/b/twin", "/left/right_twin", "/left/plant")

PATTERNS = ("twin", "/twin", "left/twin", "/*/twin", "/**/twin", "/**", "/left/*", "/*", "*/plant")


def write(folder, text, name="file.yaml"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def given_to(full_name, path):
    """Return whether ROS itself gives a node the parameters of a file."""
    namespace, _, name = full_name.rpartition("/")
    context = Context()
    words = ["--ros-args", "--params-file", path, "-r", f"__ns:={namespace or '/'}"]
    rclpy.init(context=context, args=words)
    node = Node(name, context=context, automatically_declare_parameters_from_overrides=True)
    try:
        assert node.get_fully_qualified_name() == full_name
        return node.has_parameter("x")
    finally:
        node.destroy_node()
        context.try_shutdown()


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_section_is_for_the_nodes_for_which_ros_takes_it(tmp_path, pattern):
    path = write(tmp_path, f'"{pattern}":\n  ros__parameters:\n    x: 1.0\n')
    assert sections(path) == [pattern]
    for node in NODES:
        assert is_for(pattern, node) == given_to(node, path), node


def test_nodes_may_stand_below_their_namespace(tmp_path):
    path = write(tmp_path, "left:\n  twin:\n    ros__parameters: {x: 1.0}\n")
    assert sections(path) == ["left/twin"]
    assert given_to("/left/twin", path)


def test_a_file_that_holds_nothing_for_a_node_is_named_with_its_sections(tmp_path):
    path = write(tmp_path, "plant: {ros__parameters: {}}\ntwin: {ros__parameters: {}}\n")
    other = write(tmp_path, "/**: {ros__parameters: {}}\n", "other.yaml")
    arguments = ["node", "--ros-args", "--params-file", path, "--params-file", other]
    assert unused_files(arguments, "/twin") == []
    (line,) = unused_files(arguments, "/left/twin")
    assert line == (
        f"parameter file {path}: holds nothing for /left/twin, its sections are plant, twin; "
        "a section /**/twin is for this node in any namespace"
    )


def test_an_empty_file_holds_nothing(tmp_path):
    path = write(tmp_path, "")
    (line,) = unused_files(["--ros-args", "--params-file", path], "/twin")
    assert line.startswith(f"parameter file {path}: holds nothing for /twin, it has no sections")


def test_only_what_stands_among_the_ros_arguments_is_a_parameter_file():
    words = ["--params-file", "none.yaml", "--ros-args", "-p", "x:=1", "--"]
    assert unused_files([*words, "--params-file", "none.yaml"], "/twin") == []


def test_what_is_not_yaml_is_one_line(tmp_path):
    with pytest.raises(BadInputError, match="is not YAML") as caught:
        sections(write(tmp_path, "twin: ["))
    assert "\n" not in str(caught.value)
