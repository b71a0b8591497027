"""``ros2 node``: the nodes of the graph."""

import argparse
import sys
from typing import Any

from ros2cli.errors import CommandError
from ros2cli.node_session import (
    add_group,
    add_node_arguments,
    command_node,
    is_hidden,
    wait_for_node_names,
)

__all__ = ["add_commands"]


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    verbs = add_group(groups, "node", "Various node related sub-commands")
    verb = verbs.add_parser("list", help="Output a list of available nodes")
    verb.add_argument("-a", "--all", action="store_true", help="Display all nodes even hidden ones")
    verb.add_argument("-c", "--count-nodes", action="store_true", help="Only display the number")
    add_node_arguments(verb)
    verb.set_defaults(main=_list)
    verb = verbs.add_parser("info", help="Output information about a node")
    verb.add_argument("node_name", help="Node name to request information")
    verb.add_argument(
        "--include-hidden", action="store_true", help="Display hidden topics and services as well"
    )
    add_node_arguments(verb)
    verb.set_defaults(main=_info)


def _list(arguments: argparse.Namespace) -> None:
    with command_node(arguments.spin_time) as node:
        wait_for_node_names(node)
        own = node.get_fully_qualified_name()
        names = node.get_fully_qualified_node_names()
    names = sorted(name for name in names if name != own and (arguments.all or not is_hidden(name)))
    if arguments.count_nodes:
        print(len(names))
        return
    if len(set(names)) < len(names):
        print(
            "WARNING: Be aware that there are nodes in the graph that share an exact name, "
            "which can have unintended side effects.",
            file=sys.stderr,
        )
    for name in names:
        print(name)


def _info(arguments: argparse.Namespace) -> None:
    wanted = f"/{arguments.node_name.lstrip('/')}"
    with command_node(arguments.spin_time) as node:
        wait_for_node_names(node)
        count = node.get_fully_qualified_node_names().count(wanted)
        if not count:
            raise CommandError(f"Unable to find node '{arguments.node_name}'")
        if count > 1:
            print(
                f'There are {count} nodes in the graph with the exact name "{wanted}". '
                "You are seeing information about only one of them.",
                file=sys.stderr,
            )
        namespace, _, name = wanted.rpartition("/")
        namespace = namespace or "/"
        print(wanted)
        for title, query in (
            ("Subscribers", node.get_subscriber_names_and_types_by_node),
            ("Publishers", node.get_publisher_names_and_types_by_node),
            ("Service Servers", node.get_service_names_and_types_by_node),
            ("Service Clients", node.get_client_names_and_types_by_node),
        ):
            print(f"  {title}:")
            lines = [
                f"    {entity}: {', '.join(types)}"
                for entity, types in query(name, namespace)
                if arguments.include_hidden or not is_hidden(entity)
            ]
            # Jazzy's prints an empty line where there is nothing.
            print("\n".join(lines))
        # rclpy without actions: nobody can tell which topics and services belong to one.
        print("  Action Servers:\n\n  Action Clients:\n")
