"""``ros2 node``: which nodes run, and what they use."""

import argparse
import sys

from ros2cli.errors import CommandError, did_you_mean
from ros2cli.graph import is_hidden, node_names, print_names
from ros2cli.node_session import command_node

__all__ = ["show_node", "show_nodes"]


def show_nodes(arguments: argparse.Namespace) -> None:
    """``node list``."""
    with command_node(arguments.spin_time) as node:
        names = [name for name in node_names(node) if arguments.all or not is_hidden(name)]
    shared = sorted({name for name in names if names.count(name) > 1})
    if shared and not arguments.count_nodes:
        print(f"WARNING: several nodes are called {', '.join(shared)}", file=sys.stderr)
    print_names(((name, []) for name in names), count=arguments.count_nodes)


def show_node(arguments: argparse.Namespace) -> None:
    """``node info``."""
    wanted = f"/{arguments.node_name.lstrip('/')}"
    with command_node(arguments.spin_time) as node:
        names = node_names(node)
        if wanted not in names:
            near = did_you_mean(wanted, names)
            raise CommandError(f"Unable to find node '{arguments.node_name}'{near}")
        if (count := names.count(wanted)) > 1:
            print(f"WARNING: {count} nodes are called {wanted}; this is one", file=sys.stderr)
        namespace, _, name = wanted.rpartition("/")
        whose = (name, namespace or "/")
        print(wanted)
        for title, found in (
            ("Subscribers", node.get_subscriber_names_and_types_by_node(*whose)),
            ("Publishers", node.get_publisher_names_and_types_by_node(*whose)),
            ("Service Servers", node.get_service_names_and_types_by_node(*whose)),
            ("Service Clients", node.get_client_names_and_types_by_node(*whose)),
            # rclpy without actions cannot tell which topics and services belong to one.
            ("Action Servers", []),
            ("Action Clients", []),
        ):
            lines = [
                f"    {used}: {', '.join(types)}"
                for used, types in found
                if arguments.include_hidden or not is_hidden(used)
            ]
            # An empty line stands for nothing, as in Jazzy.
            print(f"  {title}:", *(lines or [""]), sep="\n")
