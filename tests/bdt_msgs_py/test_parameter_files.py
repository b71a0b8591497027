"""Which sections of a parameter file are for a node, and what is said of a file without any."""

from dataclasses import dataclass
from pathlib import Path

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_files import (
    checked_parameters,
    is_for,
    read_sections,
    sections,
    unused_files,
)
from bdt_msgs_py.quantities import quantity

NODES = ("/twin", "/left/twin", "/a/b/twin", "/left/right_twin", "/left/plant")

PATTERNS = ("twin", "/twin", "left/twin", "/*/twin", "/**/twin", "/**", "/left/*", "/*", "*/plant")


@dataclass(frozen=True)
class Gate:
    """Parameters of a node."""

    width: float = quantity(1.0, "m", "width", minimum=0.0, maximum=2.0)


GATE = (("gate", Gate),)


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


def test_a_file_for_one_of_the_nodes_of_a_process_is_used(tmp_path):
    path = write(tmp_path, "driver: {ros__parameters: {}}\n")
    other = write(tmp_path, "plant: {ros__parameters: {}}\n", "other.yaml")
    arguments = ["--ros-args", "--params-file", path, "--params-file", other]
    (line,) = unused_files(arguments, "/controller", "/driver")
    assert line == (
        f"parameter file {other}: holds nothing for /controller or /driver, its sections are "
        "plant; a section /**/controller or /**/driver is for this node in any namespace"
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


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "must be a ROS parameter file with nodes"),
        ("- 1", "must be a ROS parameter file with nodes"),
        ("a: [\n  b: {\n", "is not YAML: while parsing a flow node"),
    ],
)
def test_what_is_no_parameter_file_is_one_line_with_the_name_that_the_caller_has_for_it(
    tmp_path, text, says
):
    with pytest.raises(BadInputError, match=rf"^--gates FILE: {says}") as caught:
        read_sections("--gates FILE", Path(write(tmp_path, text)))
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_there_is_called_what_the_caller_calls_it(tmp_path):
    with pytest.raises(BadInputError, match=r"^--gates FILE: cannot be read: No such file"):
        read_sections("--gates FILE", tmp_path / "none.yaml")


def test_what_a_section_sets_has_the_names_of_parameters_however_it_is_nested():
    for parameters in ({"gate.width": 1.5}, {"gate": {"width": 1.5}}):
        assert checked_parameters("x", parameters, GATE, for_all=False) == {"gate.width": 1.5}


def test_what_every_node_has_is_set_unchecked():
    parameters = {"use_sim_time": True, "qos_overrides": {"/clock": {"depth": 1}}}
    assert checked_parameters("x", parameters, GATE, for_all=False) == {
        "use_sim_time": True,
        "qos_overrides./clock.depth": 1,
    }


def test_an_unknown_name_is_refused_unless_the_section_is_for_all_nodes():
    parameters = {"gate": {"widht": 1.5}}
    assert checked_parameters("x", parameters, GATE, for_all=True) == {}
    says = r"^x: gate.widht = 1.5: is not a parameter of this node; did you mean gate.width\?"
    with pytest.raises(BadInputError, match=says):
        checked_parameters("x", parameters, GATE, for_all=False)


@pytest.mark.parametrize("for_all", [False, True])
def test_a_value_that_is_not_allowed_is_refused_in_any_section(for_all):
    with pytest.raises(BadInputError, match=r"^x: gate.width = 3.0 m: must be 0 to 2 m"):
        checked_parameters("x", {"gate.width": 3.0}, GATE, for_all=for_all)
