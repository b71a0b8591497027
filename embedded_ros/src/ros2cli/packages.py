"""``ros2 pkg`` and ``ros2 run``: packages and their executables, where pip has put them."""

import argparse
import json
import os
import shlex
import sys
from importlib.metadata import Distribution, EntryPoint, PackageNotFoundError, distributions
from pathlib import Path
from urllib.parse import unquote, urlsplit

from ros2cli.errors import CommandError, did_you_mean
from ros2cli.interface_texts import interface_names

__all__ = ["run", "show_executables", "show_packages"]

#: No ROS package by its files, but it brings ``ros2``.
_EMBEDDED = "embedded_ros"

# What a console script does, without the script: it need not be on the path.
_LAUNCH = (
    "import sys; from importlib import import_module; from operator import attrgetter; "
    "sys.argv[0] = {name!r}; "
    "sys.exit(attrgetter({attribute!r})(import_module({module!r}))())"
)


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


def _package_names() -> list[str]:
    """ROS packages that offer an executable, sorted; names with underscores as in ROS."""
    found = (item for item in distributions() if _entry_points(item) and _is_ros_package(item))
    return sorted({_name(distribution) for distribution in found})


def _executables_of(package: str) -> dict[str, EntryPoint]:
    """Executables of a package, sorted by name."""
    try:
        distribution = Distribution.from_name(package.replace("_", "-"))
    except (PackageNotFoundError, ValueError):
        near = did_you_mean(package, _package_names())
        raise CommandError(f"Package '{package}' not found{near}") from None
    return {entry.name: entry for entry in sorted(_entry_points(distribution))}


def show_packages(_arguments: argparse.Namespace) -> None:
    """``pkg list``."""
    with_types = (package for kind in ("msg", "srv") for package in interface_names(kind))
    for name in sorted({*_package_names(), *with_types}):
        print(name)


def show_executables(arguments: argparse.Namespace) -> None:
    """``pkg executables``."""
    only = arguments.package_name
    for package in [only] if only else _package_names():
        for name in _executables_of(package):
            print(package, name)


def run(arguments: argparse.Namespace) -> None:
    """``run``: the executable replaces this process, so signals and the exit code are its own."""
    name = arguments.executable_name
    known = _executables_of(arguments.package_name)
    if name not in known:
        raise CommandError(f"No executable found{did_you_mean(name, known)}")
    entry = known[name]
    code = _LAUNCH.format(name=name, attribute=entry.attr, module=entry.module)
    try:
        prefix = shlex.split(arguments.prefix or "")
    except ValueError as error:
        raise CommandError(f"--prefix '{arguments.prefix}': {error}") from None
    command = [*prefix, sys.executable, "-c", code, *arguments.argv]
    try:
        os.execvp(command[0], command)  # noqa: S606
    except OSError as error:
        raise CommandError(f"Could not start '{command[0]}': {error.strerror}") from None
