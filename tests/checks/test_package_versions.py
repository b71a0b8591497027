"""One version in all packages: a different one is found, a new one is written everywhere."""

import shutil
import tomllib
from pathlib import Path

import pytest

from checks.package_versions import project_version, version_problems, write_version

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture
def copy(tmp_path):
    """Return a copy of the files that state a version."""
    files = [*REPOSITORY.glob("src/*/package.xml")]
    files += [REPOSITORY / "pyproject.toml", REPOSITORY / "embedded_ros" / "pyproject.toml"]
    for file in files:
        target = tmp_path / file.relative_to(REPOSITORY)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(file, target)
    return tmp_path


def replace(file, old, new):
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))


def test_the_packages_of_this_repository_have_one_version():
    assert version_problems(REPOSITORY) == []


def test_a_package_with_another_version_is_found(copy):
    manifest = copy / "src" / "bdt_twin" / "package.xml"
    version = project_version(copy)
    replace(manifest, f"<version>{version}<", "<version>9.8.7<")
    assert version_problems(copy) == [
        f"{manifest}: version 9.8.7: must be {version}, as in pyproject.toml"
    ]


@pytest.mark.parametrize("requirement", ["bdt_twin", "embedded-ros", "bdt_analysis[parquet]"])
def test_a_requirement_for_another_version_is_found(copy, requirement):
    version = project_version(copy)
    replace(copy / "pyproject.toml", f'"{requirement}=={version}"', f'"{requirement}==9.8.7"')
    (problem,) = version_problems(copy)
    assert problem.startswith("pyproject.toml: ")


def test_a_package_that_the_whole_does_not_require_is_found(copy):
    replace(copy / "pyproject.toml", f'"bdt_twin=={project_version(copy)}",', "")
    (problem,) = version_problems(copy)
    assert "dependencies: must be bdt_analysis==" in problem


def test_a_version_is_written_everywhere(copy):
    write_version(copy, "9.8.7")
    assert version_problems(copy) == []
    assert project_version(copy) == "9.8.7"
    project = tomllib.loads((copy / "pyproject.toml").read_text())
    before = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())
    assert {**project, "project": None} == {**before, "project": None}


def test_a_version_is_three_numbers(copy):
    with pytest.raises(ValueError, match=r"version 0\.2: must be three numbers"):
        write_version(copy, "0.2")


@pytest.mark.parametrize("package", sorted(x.parent for x in REPOSITORY.glob("src/*/package.xml")))
def test_every_package_carries_the_license(package):
    assert (package / "LICENSE").read_bytes() == (REPOSITORY / "LICENSE").read_bytes()


def test_embedded_ros_carries_the_license():
    license_file = REPOSITORY / "embedded_ros" / "LICENSE"
    assert license_file.read_bytes() == (REPOSITORY / "LICENSE").read_bytes()
