"""The version of the project: one for all packages, written in each because each installs apart.

``python -m checks.package_versions`` checks that they agree, ``... VERSION`` writes a new one.
"""

import re
import sys
import tomllib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

ROOT_PROJECT = Path("pyproject.toml")
EMBEDDED_PROJECT = Path("embedded_ros/pyproject.toml")
MANIFESTS = "src/*/package.xml"

_VERSION = re.compile(r"\d+\.\d+\.\d+")


def main() -> None:
    """Check the versions, or write the one that is given; exit with 1 where they differ."""
    root = Path()
    if len(sys.argv) > 1:
        try:
            write_version(root, sys.argv[1])
        except ValueError as error:
            sys.exit(f"error: {error}")
    problems = version_problems(root)
    if problems:
        sys.exit("\n".join(f"error: {problem}" for problem in problems))
    print(f"version {project_version(root)} in all packages")


def project_version(root: Path) -> str:
    """Return the version that the project in `root` states for itself."""
    return str(_project(root / ROOT_PROJECT)["version"])


def version_problems(root: Path) -> list[str]:
    """Return where the version, or a requirement for exactly that version, is another one.

    Parameters
    ----------
    root : Path
        Folder of the repository.
    """
    version = project_version(root)
    manifests = sorted(root.glob(MANIFESTS))
    stated = {manifest: ET.parse(manifest).findtext("version") for manifest in manifests}
    stated[root / EMBEDDED_PROJECT] = _project(root / EMBEDDED_PROJECT)["version"]
    project = _project(root / ROOT_PROJECT)
    expected = sorted(f"{manifest.parent.name}=={version}" for manifest in manifests)
    problems = [
        f"{file}: version {found}: must be {version}, as in {ROOT_PROJECT}"
        for file, found in stated.items()
        if found != version
    ]
    if sorted(project["dependencies"]) != expected:
        problems.append(f"{ROOT_PROJECT}: dependencies: must be {', '.join(expected)}")
    extras = [text for texts in project["optional-dependencies"].values() for text in texts]
    return problems + [
        f"{ROOT_PROJECT}: {text}: must end with =={version}"
        for text in extras
        if not text.endswith(f"=={version}")
    ]


def write_version(root: Path, version: str) -> None:
    """Write a version wherever it stands.

    Parameters
    ----------
    root : Path
        Folder of the repository.
    version : str
        Three numbers with dots, as package.xml wants them.

    Raises
    ------
    ValueError
        If `version` is something else.
    """
    if not _VERSION.fullmatch(version):
        raise ValueError(f"version {version}: must be three numbers with dots, such as 0.2.0")
    tag = re.compile(r"(?<=<version>)[^<]*(?=</version>)")
    for manifest in root.glob(MANIFESTS):
        _substitute(manifest, tag, version)
    setting = re.compile(r'(?<=^version = ")[^"]*(?=")', re.MULTILINE)
    exactly = re.compile(r'(?<===)[\d.]+(?=")')
    for file in (ROOT_PROJECT, EMBEDDED_PROJECT):
        _substitute(root / file, setting, version)
    _substitute(root / ROOT_PROJECT, exactly, version)


def _project(file: Path) -> dict[str, Any]:
    project: dict[str, Any] = tomllib.loads(file.read_text(encoding="utf-8"))["project"]
    return project


def _substitute(file: Path, pattern: re.Pattern[str], text: str) -> None:
    file.write_text(pattern.sub(text, file.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
