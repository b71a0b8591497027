"""``ros2 node``: the nodes of the graph."""

import argparse
from typing import Any

from ros2cli.errors import CommandError
from ros2cli.node_session import add_spin_time, command_node, is_hidden

__all__ = ["add_commands"]


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    group = groups.add_parser("node", help="Various node related sub-commands")
    verbs = group.add_subparsers(title="Commands", required=True)
    verb = verbs.add_parser("list", help="Output a list of available nodes")
    verb.add_argument("-a", "--all", action="store_true", help="Display all nodes even hidden ones")
    verb.add_argument("-c", "--count-nodes", action="store_true", help="Only display the number")
    add_spin_time(verb)
    verb.set_defaults(main=_list)
    verb = verbs.add_parser("info", help="Output information about a node")
    verb.add_argument("node_name", help="Node name to request information")
    add_spin_time(verb)
    verb.set_defaults(main=_info)


def _list(arguments: argparse.Namespace) -> None:
    with command_node(arguments.spin_time) as node:
        names = node.get_fully_qualified_node_names()
    names = sorted(name for name in names if arguments.all or not is_hidden(name))
    if arguments.count_nodes:
        print(len(names))
    else:
        for name in names:
            print(name)


def _info(arguments: argparse.Namespace) -> None:
    wanted = f"/{arguments.node_name.lstrip('/')}"
    with command_node(arguments.spin_time) as node:
        if wanted not in node.get_fully_qualified_node_names():
            raise CommandError(f"Unable to find node '{arguments.node_name}'")
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
            for entity, types in query(name, namespace):
                if not is_hidden(entity):
                    print(f"    {entity}: {', '.join(types)}")
