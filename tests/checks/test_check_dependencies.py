"""What a package imports without declaring it is found, and what it declares in vain."""

import re
import tomllib
from pathlib import Path

import pytest

from checks import check_dependencies
from checks.check_dependencies import dependency_problems, idle_exceptions
from checks.dependency_table import PROVIDERS
from checks.imported_packages import imported_packages

SOURCES = Path(__file__).parents[2] / "src"
EMBEDDED_ROS = SOURCES.parent / "embedded_ros"


@pytest.fixture
def write_package(tmp_path):
    """Return a function that writes a package and returns its folder."""

    def write(source, *, rosdep_keys=(), required=(), extras=None):
        package = tmp_path / "bdt_tried"
        (package / "bdt_tried").mkdir(parents=True)
        (package / "bdt_tried" / "core.py").write_text(source)
        depends = "".join(f"<exec_depend>{key}</exec_depend>" for key in rosdep_keys)
        (package / "package.xml").write_text(f'<package format="3">{depends}</package>')
        (package / "setup.py").write_text(
            f"from setuptools import setup\n"
            f"setup(install_requires={list(required)!r}, extras_require={extras or {}!r})\n"
        )
        return package

    return write


def test_the_packages_of_this_repository_declare_what_they_import():
    packages = [file.parent for file in SOURCES.glob("*/package.xml")]
    assert len(packages) == 12
    assert [problem for package in packages for problem in dependency_problems(package)] == []


def test_embedded_ros_requires_what_it_imports():
    project = tomllib.loads((EMBEDDED_ROS / "pyproject.toml").read_text())["project"]
    packages = [folder for folder in (EMBEDDED_ROS / "src").iterdir() if folder.is_dir()]
    own = {folder.name for folder in packages}
    imported = {name for folder in packages for name in imported_packages(folder)} - own
    required = {re.split(r"[^\w-]", text)[0] for text in project["dependencies"]}
    assert {PROVIDERS[name].distribution for name in imported} == required


def test_what_is_declared_and_imported_is_right(write_package):
    package = write_package(
        "import json\nimport numpy as np\nfrom rclpy.node import Node\n"
        "from bdt_plant import motor\nfrom bdt_tried.core import x\nfrom . import core\n",
        rosdep_keys=["python3-numpy", "rclpy", "bdt_plant"],
        required=["numpy>=1.26", "bdt_plant"],
    )
    assert dependency_problems(package) == []


@pytest.mark.parametrize(
    "source",
    [
        "import scipy.linalg",
        "from scipy import linalg",
        "def late():\n    from scipy import linalg",
        "from importlib import import_module\nimport_module('scipy.linalg')",
        "import importlib.util\nimportlib.util.find_spec('scipy')",
    ],
)
def test_what_is_missing_is_found_wherever_it_is_imported(write_package, source):
    first, second = dependency_problems(write_package(source))
    place = f"core.py:{1 + source.count(chr(10))} imports scipy)"
    assert first.startswith("bdt_tried/package.xml: exec_depend is missing: python3-scipy (")
    assert second.startswith("bdt_tried/setup.py: install_requires lacks scipy (")
    assert first.endswith(place)
    assert second.endswith(place)


def test_a_package_of_ours_is_not_imported_without_being_declared(write_package):
    first, second = dependency_problems(write_package("import bdt_plant"))
    assert "exec_depend is missing: bdt_plant" in first
    assert "install_requires lacks bdt_plant" in second


def test_what_is_superfluous_is_found(write_package):
    package = write_package(
        "import json", rosdep_keys=["python3-numpy", "std_msgs"], required=["rich>=13"]
    )
    assert dependency_problems(package) == [
        "bdt_tried/package.xml: exec_depend is superfluous: python3-numpy",
        "bdt_tried/package.xml: exec_depend is superfluous: std_msgs",
        "bdt_tried/setup.py: rich is superfluous",
    ]


def test_what_ros_alone_has_is_not_for_pip(write_package):
    package = write_package("import rclpy", rosdep_keys=["rclpy"], required=["rclpy"])
    assert dependency_problems(package) == ["bdt_tried/setup.py: rclpy is superfluous"]


def test_an_extra_declares_for_pip_and_is_not_required_as_well(write_package):
    package = write_package(
        "import rich",
        rosdep_keys=["python3-rich"],
        required=["rich>=13"],
        extras={"colors": ["rich>=13"]},
    )
    assert dependency_problems(package) == [
        "bdt_tried/setup.py: rich is required, so no extra needs it"
    ]


def test_what_rosdep_has_no_key_for_needs_a_reason(write_package):
    package = write_package("import pyarrow", extras={"parquet": ["pyarrow>=14"]})
    (problem,) = dependency_problems(package)
    assert "no key known: give a reason" in problem


def test_a_package_that_the_table_does_not_know_is_asked_for(write_package):
    (problem,) = dependency_problems(write_package("import requests"))
    assert problem.endswith("core.py:1: requests: is not in checks/dependency_table.py")


def test_requirements_that_are_computed_are_refused(write_package):
    package = write_package("import json")
    (package / "setup.py").write_text("setup(install_requires=sorted(names))")
    with pytest.raises(ValueError, match="install_requires: must be written as literals"):
        dependency_problems(package)


def test_an_exception_that_nothing_needs_any_more_is_found():
    needed = {"numpy", "SALib", "distributed", "pyarrow"}
    (problem,) = idle_exceptions({"bdt_study": needed})
    assert problem == "checks/dependency_table.py: bdt_study: imports no cyclonedds"


def test_one_key_may_bring_several_packages():
    assert PROVIDERS["lz4"].rosdep_key == PROVIDERS["rosbags"].rosdep_key


def test_a_problem_ends_the_check_with_exit_code_one(write_package, monkeypatch, capsys):
    package = write_package("import scipy")
    monkeypatch.setattr("sys.argv", ["check_dependencies", str(package)])
    with pytest.raises(SystemExit) as ended:
        check_dependencies.main()
    assert ended.value.code == 1
    assert capsys.readouterr().err.count("error: ") == 2
