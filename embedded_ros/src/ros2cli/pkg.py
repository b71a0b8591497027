"""``ros2 pkg``: packages and their executables."""

import argparse
from typing import Any

from ros2cli.executables import executables_of, package_names
from ros2cli.interface_texts import interface_names
from ros2cli.node_session import add_group

__all__ = ["add_commands"]


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    verbs = add_group(groups, "pkg", "Various package related sub-commands")
    verb = verbs.add_parser("executables", help="Output a list of package specific executables")
    verb.add_argument("package_name", nargs="?", help="The package name")
    verb.set_defaults(main=_executables)
    verb = verbs.add_parser("list", help="Output a list of available packages")
    verb.set_defaults(main=_list)


def _list(_arguments: argparse.Namespace) -> None:
    interfaces = (package for kind in ("msg", "srv") for package in interface_names(kind))
    for name in sorted({*package_names(), *interfaces}):
        print(name)


def _executables(arguments: argparse.Namespace) -> None:
    names = [arguments.package_name] if arguments.package_name else package_names()
    for name in names:
        for entry in executables_of(name):
            print(f"{name} {entry.name}")
