"""Executables of packages, found where pip has put them."""

import json
from importlib.metadata import Distribution, EntryPoint, PackageNotFoundError, distributions
from pathlib import Path
from urllib.parse import unquote, urlsplit

from ros2cli.errors import CommandError

__all__ = ["executables_of", "find_executable", "package_names"]

#: No ROS package by its files, but it brings ``ros2``.
_EMBEDDED = "embedded_ros"


def _name(distribution: Distribution) -> str:
    return str(distribution.metadata["Name"]).replace("-", "_").lower()


def _entry_points(distribution: Distribution) -> list[EntryPoint]:
    return [entry for entry in distribution.entry_points if entry.group == "console_scripts"]


def _is_ros_package(distribution: Distribution) -> bool:
    """Whether a distribution has a ``package.xml``, installed or where it is edited."""
    if _name(distribution) == _EMBEDDED:
        return True
    if any(file.name == "package.xml" for file in distribution.files or ()):
        return True
    origin = json.loads(distribution.read_text("direct_url.json") or "{}").get("url", "")
    return (
        origin.startswith("file:")
        and (Path(unquote(urlsplit(origin).path)) / "package.xml").is_file()
    )


def package_names() -> list[str]:
    """ROS packages that offer an executable, sorted; names with underscores as in ROS."""
    found = (item for item in distributions() if _entry_points(item) and _is_ros_package(item))
    return sorted({_name(distribution) for distribution in found})


def executables_of(package: str) -> list[EntryPoint]:
    """Executables of a package, sorted by name."""
    try:
        distribution = Distribution.from_name(package.replace("_", "-"))
    except (PackageNotFoundError, ValueError):
        raise CommandError(f"Package '{package}' not found") from None
    return sorted(_entry_points(distribution), key=lambda entry: entry.name)


def find_executable(package: str, name: str) -> EntryPoint:
    """Executable of a package."""
    for entry in executables_of(package):
        if entry.name == name:
            return entry
    raise CommandError("No executable found")
