"""Subcommands, nodes and parameters are found in the packages that are installed, by name."""

import ast
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from bdt_bringup import installed
from bdt_bringup.cli import run_command
from bdt_bringup.installed import (
    PACKAGE_OF_COMMAND,
    PACKAGE_OF_NODE,
    installed_commands,
    missing_packages,
    node_class,
    node_module,
    parameter_table,
)
from bdt_msgs_py.command_errors import BAD_INPUT, BadInputError
from bdt_msgs_py.commands import COMMAND_GROUP, NODE_GROUP, PARAMETER_GROUP

SOURCES = Path(__file__).parents[2] / "src"


def declared(group):
    """Return the packages by the names of a group of entry points, as the setup.py files say."""
    packages = {}
    for setup in SOURCES.glob("*/setup.py"):
        for node in ast.walk(ast.parse(setup.read_text(encoding="utf-8"))):
            if isinstance(node, ast.keyword) and node.arg == "entry_points":
                points = ast.literal_eval(node.value).get(group, [])
                packages |= {point.split(" = ")[0]: setup.parent.name for point in points}
    return packages


@pytest.fixture
def without(monkeypatch):
    """Return a function that hides the entry points of a package."""

    def hide(package):
        def visible(group):
            points = entry_points(group=group)
            return {x.name: x for x in points if x.module.partition(".")[0] != package}

        monkeypatch.setattr(installed, "_entry_points", visible)

    return hide


def test_the_packages_bring_the_commands_that_the_help_of_a_missing_one_names():
    assert declared(COMMAND_GROUP) == PACKAGE_OF_COMMAND


def test_the_packages_bring_the_nodes_of_the_loop():
    assert declared(NODE_GROUP) == PACKAGE_OF_NODE


def test_they_bring_the_parameters_of_those():
    assert declared(PARAMETER_GROUP) == PACKAGE_OF_NODE


def test_commands_are_listed_in_the_order_of_their_use():
    assert list(installed_commands()) == list(PACKAGE_OF_COMMAND)


@pytest.mark.parametrize("node", PACKAGE_OF_NODE)
def test_a_node_is_a_class_in_a_module_with_a_main_and_has_a_table_of_parameters(node):
    kind = node_class(node)
    assert kind.__module__ == node_module(node)
    assert kind.__name__.lower() == f"{node}node"
    assert all(isinstance(prefix, str) for prefix, _ in parameter_table(node))


def test_what_is_not_installed_is_not_listed(without, capsys):
    without("bdt_study")
    assert "reproduce" not in installed_commands()
    with pytest.raises(SystemExit) as ended:
        run_command(["--help"])
    assert ended.value.code == 0
    assert "reproduce" not in capsys.readouterr().out


def test_asking_for_it_says_which_package_has_it(without, capsys):
    without("bdt_study")
    with pytest.raises(SystemExit) as ended:
        run_command(["reproduce"])
    assert ended.value.code == BAD_INPUT
    said = capsys.readouterr().err
    assert said.endswith("error: reproduce: is a command of the package bdt_study, install it\n")


def test_a_run_without_a_package_that_it_needs_says_which(without, capsys, tmp_path):
    without("bdt_bags")
    assert missing_packages(list(PACKAGE_OF_NODE)) == ["bdt_bags"]
    assert run_command(["run", "--output", str(tmp_path / "run")]) == BAD_INPUT
    assert capsys.readouterr().err == "error: bdt run: needs the package bdt_bags, install it\n"
    assert not (tmp_path / "run").exists()


def test_the_parameters_of_a_node_that_is_not_installed_name_its_package(without):
    without("bdt_twin")
    with pytest.raises(BadInputError, match="node twin: is in the package bdt_twin, install it"):
        parameter_table("twin")


def test_an_unknown_command_is_answered_with_those_that_there_are(capsys):
    with pytest.raises(SystemExit) as ended:
        run_command(["analyse"])
    assert ended.value.code == BAD_INPUT
    assert "invalid choice: 'analyse'" in capsys.readouterr().err
