"""``ros2 service`` but for calls: which services there are."""

import argparse

from ros2cli.errors import CommandError, did_you_mean
from ros2cli.graph import print_names, services
from ros2cli.node_session import command_node

__all__ = ["show_information", "show_of_type", "show_services", "show_type"]


def _found(arguments: argparse.Namespace) -> list[tuple[str, list[str]]]:
    with command_node(arguments.spin_time) as node:
        return services(node, hidden=arguments.include_hidden_services)


def show_services(arguments: argparse.Namespace) -> None:
    """``service list``."""
    print_names(_found(arguments), types=arguments.show_types, count=arguments.count_services)


def show_of_type(arguments: argparse.Namespace) -> None:
    """``service find``."""
    matching = [item for item in _found(arguments) if arguments.service_type in item[1]]
    print_names(matching, count=arguments.count_services)


def show_type(arguments: argparse.Namespace) -> int:
    """``service type``: silence and exit code 1 for a service that nobody has."""
    with command_node(arguments.spin_time) as node:
        types = dict(services(node, hidden=True)).get(arguments.service_name, [])
    print_names((name, []) for name in types)
    return 0 if types else 1


def show_information(arguments: argparse.Namespace) -> None:
    """``service info``."""
    name = arguments.service_name
    with command_node(arguments.spin_time) as node:
        known = dict(services(node, hidden=True))
        if name not in known:
            raise CommandError(f"Unknown service '{name}'{did_you_mean(name, known)}")
        clients, servers = node.count_clients(name), node.count_services(name)
    (single, *more) = types = known[name]
    print(f"Type: {types if more else single}")
    print(f"Clients count: {clients}\nServices count: {servers}")
