"""The documentation builds without a warning, and its reference leaves nothing out."""

import argparse
import inspect
import pkgutil
import subprocess
import sys
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path

import pytest

from bdt_bringup.cli import command_parser
from bdt_bringup.installed import installed_commands
from bdt_msgs_py.parameter_tables import known_parameters
from bdt_msgs_py.topics import ALL_TOPICS

ROOT = Path(__file__).parents[2]
SOURCE, BUILD = ROOT / "docs" / "source", ROOT / "docs" / "build"
KINDS = ("class", "exception", "function")
PACKAGES = sorted(path.parent.name for path in ROOT.glob("src/*/package.xml"))


@pytest.fixture(scope="module")
def html():
    """Build the documentation as `make docs` does, and return its folder.

    Without the functions in the sidebars: Sphinx copies them for every page, half of its work.
    """
    pytest.importorskip("furo", reason="`make test` installs what the documentation needs")
    command = [sys.executable, "-m", "sphinx", "--quiet", "--fail-on-warning"]
    options = ["--keep-going", "--define", "toc_object_entries=0", "--builder", "html"]
    built = subprocess.run(
        [*command, *options, SOURCE, BUILD / "tested"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert built.returncode == 0, built.stderr
    return BUILD / "tested"


@pytest.fixture(scope="module")
def described(html):
    """Return what Sphinx has described: names by kind."""
    from sphinx.util.inventory import InventoryFile

    inventory = InventoryFile.loads((html / "objects.inv").read_bytes(), uri="")
    return {kind: set(names) for kind, names in inventory.data.items()}


def test_pages_of_modules_that_are_gone_are_forgotten(tmp_path, monkeypatch):
    pytest.importorskip("docutils")
    monkeypatch.syspath_prepend(SOURCE / "extensions")
    from python_packages import forget_old_pages

    folder, contents = tmp_path / "generated", {"bdt_twin": {"packages": [], "modules": ["a", "b"]}}
    forget_old_pages(folder, contents)
    page = folder / "bdt_twin.rst"
    page.write_text("a b", encoding="utf-8")
    forget_old_pages(folder, contents)
    assert page.exists()
    forget_old_pages(folder, {"bdt_twin": {"packages": [], "modules": ["a"]}})
    assert not page.exists()


def public_names(package):
    """Iterate over the public functions and classes of a package, by their full names."""
    path = import_module(package).__path__
    for item in pkgutil.walk_packages(path, f"{package}."):
        module = import_module(item.name)
        for name, member in vars(module).items():
            own = getattr(member, "__module__", None) == item.name
            if (
                own
                and not name.startswith("_")
                and inspect.isroutine(member) | inspect.isclass(member)
            ):
                yield f"{item.name}.{name}"


def test_every_topic_has_a_row(html):
    page = (html / "reference" / "topics.html").read_text(encoding="utf-8")
    assert [topic.name for topic in ALL_TOPICS if f">{topic.name}<" not in page] == []


@pytest.mark.parametrize("node", ["plant", "controller", "driver", "twin", "recorder"])
def test_every_parameter_has_a_row(html, node):
    page = (html / "reference" / "parameters.html").read_text(encoding="utf-8")
    (table,) = entry_points(group="bdt.parameters", name=node)
    known = known_parameters(table.load())
    assert known
    assert [name for name in known if f'id="{node}.{name}"' not in page] == []


def test_every_option_of_every_command_is_described(described):
    missing = []
    parser = command_parser(installed_commands())
    (commands,) = (a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    for name, command in commands.choices.items():
        for action in command._actions:
            missing += [
                f"{name} {option}"
                for option in action.option_strings
                if option not in ("-h", "--help")
                and f"bdt-{name}.{option}" not in described["std:cmdoption"]
            ]
    assert missing == []


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_function_and_class_is_described(described, package):
    names = set(public_names(package))
    assert names
    assert (
        names - set().union(*(described[kind] for kind in described if kind[:3] == "py:")) == set()
    )
