"""``ros2 interface``: message and service types."""

import argparse
import sys
from typing import Any

from ros2cli.errors import CommandError
from ros2cli.interface_texts import definition_lines, interface_names, nested_type
from ros2cli.node_session import add_group

__all__ = ["add_commands"]

_KINDS = {"msg": "Messages", "srv": "Services", "action": "Actions"}


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    verbs = add_group(groups, "interface", "Show information about ROS interfaces")
    verb = verbs.add_parser("list", help="List all interface types available")
    _add_kinds(verb)
    verb.set_defaults(main=_list)
    verb = verbs.add_parser(
        "package", help="Output a list of available interface types within one package"
    )
    verb.add_argument("package_name")
    verb.set_defaults(main=_package)
    verb = verbs.add_parser("packages", help="Output a list of packages that provide interfaces")
    _add_kinds(verb)
    verb.set_defaults(main=_packages)
    verb = verbs.add_parser("show", help="Output the interface definition")
    verb.add_argument("type", help="For example std_msgs/msg/String; '-' reads it from stdin")
    group = verb.add_mutually_exclusive_group()
    group.add_argument(
        "--all-comments", action="store_true", help="Show all comments, those of nested types too"
    )
    group.add_argument("--no-comments", action="store_true", help="Show no comments or whitespace")
    verb.set_defaults(main=_show)


def _add_kinds(verb: argparse.ArgumentParser) -> None:
    for kind, title in _KINDS.items():
        verb.add_argument(
            f"-{kind[0]}",
            f"--only-{kind}s",
            action="append_const",
            dest="kinds",
            const=kind,
            help=f"Only the {title.lower()}",
        )


def _list(arguments: argparse.Namespace) -> None:
    for kind in arguments.kinds or _KINDS:
        print(f"{_KINDS[kind]}:")
        for package, names in interface_names(kind).items():
            for name in names:
                print(f"    {package}/{kind}/{name}")


def _packages(arguments: argparse.Namespace) -> None:
    kinds = arguments.kinds or _KINDS
    for package in sorted({package for kind in kinds for package in interface_names(kind)}):
        print(package)


def _package(arguments: argparse.Namespace) -> None:
    package = arguments.package_name
    found = [
        f"{package}/{kind}/{name}"
        for kind in _KINDS
        for name in interface_names(kind).get(package, [])
    ]
    if not found:
        raise CommandError(f"Unknown package '{package}'")
    print(*found, sep="\n")


def _show(arguments: argparse.Namespace) -> None:
    type_name = sys.stdin.readline().strip() if arguments.type == "-" else arguments.type
    _print_definition(
        type_name,
        with_comments=not arguments.no_comments,
        with_nested_comments=arguments.all_comments,
        indent="",
    )


def _print_definition(
    type_name: str, *, with_comments: bool, with_nested_comments: bool, indent: str
) -> None:
    for line in definition_lines(type_name):
        text = line if with_comments else _without_comment(line)
        if text or with_comments:
            print(f"{indent}{text}" if text else "")
        nested = nested_type(line, type_name.split("/", maxsplit=1)[0])
        if nested:
            _print_definition(
                nested,
                with_comments=with_nested_comments,
                with_nested_comments=with_nested_comments,
                indent=f"{indent}\t",
            )


def _without_comment(line: str) -> str:
    # A number sign in a string constant or default is text.
    code, sign, _ = line.partition("#")
    return line if sign and '"' in code and code.count('"') % 2 else code.rstrip()
