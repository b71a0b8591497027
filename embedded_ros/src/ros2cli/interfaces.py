"""``ros2 interface``: what messages and services consist of."""

import argparse
import sys
from collections.abc import Iterator

from ros2cli.errors import CommandError, did_you_mean
from ros2cli.interface_texts import definition_lines, interface_names, nested_type

__all__ = ["show_definition", "show_packages", "show_types", "show_types_of_package"]

_TITLES = {"msg": "Messages", "srv": "Services", "action": "Actions"}


def show_types(arguments: argparse.Namespace) -> None:
    """``interface list``."""
    for kind in arguments.kinds or _TITLES:
        print(f"{_TITLES[kind]}:")
        for package, names in interface_names(kind).items():
            for name in names:
                print(f"    {package}/{kind}/{name}")


def show_packages(arguments: argparse.Namespace) -> None:
    """``interface packages``."""
    for package in _packages(arguments.kinds or _TITLES):
        print(package)


def show_types_of_package(arguments: argparse.Namespace) -> None:
    """``interface package``."""
    package = arguments.package_name
    if package not in (known := _packages(_TITLES)):
        raise CommandError(f"Unknown package '{package}'{did_you_mean(package, known)}")
    for kind in _TITLES:
        for name in interface_names(kind).get(package, ()):
            print(f"{package}/{kind}/{name}")


def show_definition(arguments: argparse.Namespace) -> None:
    """``interface show``."""
    name = arguments.type
    if name == "-":
        name = sys.stdin.readline().strip()
    comments = (not arguments.no_comments, arguments.all_comments)
    for line in _lines(name, "", *comments):
        print(line)


def _packages(kinds: Iterator[str] | list[str] | dict[str, str]) -> list[str]:
    return sorted({package for kind in kinds for package in interface_names(kind)})


def _lines(name: str, indent: str, comments: bool, nested_comments: bool) -> Iterator[str]:
    """Definition of a type; below each field of a nested type that one's, indented."""
    package, _, _ = name.partition("/")
    for line in definition_lines(name):
        if comments:
            yield f"{indent}{line}".rstrip()
        elif bare := _without_comment(line):
            yield f"{indent}{bare}"
        if nested := nested_type(line, package):
            yield from _lines(nested, f"{indent}\t", nested_comments, nested_comments)


def _without_comment(line: str) -> str:
    # A number sign in a text, such as a constant or a default, begins no comment.
    before, sign, _ = line.partition("#")
    return line if sign and before.count('"') % 2 else before.rstrip()
