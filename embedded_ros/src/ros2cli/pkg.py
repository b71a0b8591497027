"""``ros2 pkg``: packages and their executables."""

import argparse
from typing import Any

from ros2cli.executables import executables_of, package_names

__all__ = ["add_commands"]


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    group = groups.add_parser("pkg", help="Various package related sub-commands")
    verbs = group.add_subparsers(title="Commands", required=True)
    verb = verbs.add_parser("list", help="Output a list of available packages")
    verb.set_defaults(main=_list)
    verb = verbs.add_parser("executables", help="Output a list of package specific executables")
    verb.add_argument("package_name", nargs="?", help="The package name")
    verb.set_defaults(main=_executables)


def _list(_arguments: argparse.Namespace) -> None:
    for name in package_names():
        print(name)


def _executables(arguments: argparse.Namespace) -> None:
    names = [arguments.package_name] if arguments.package_name else package_names()
    for name in names:
        for entry in executables_of(name):
            print(f"{name} {entry.name}")
