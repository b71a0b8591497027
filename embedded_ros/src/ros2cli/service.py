"""``ros2 service``: services and calls of them."""

import argparse
from typing import Any

import rclpy
from ros2cli.errors import CommandError
from ros2cli.messages import fill, import_type, parse_values
from ros2cli.node_session import add_spin_time, command_node, is_hidden

__all__ = ["add_commands"]


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    group = groups.add_parser("service", help="Various service related sub-commands")
    verbs = group.add_subparsers(title="Commands", required=True)
    verb = verbs.add_parser("list", help="Output a list of available services")
    verb.add_argument("-t", "--show-types", action="store_true", help="Additionally show the type")
    add_spin_time(verb)
    verb.set_defaults(main=_list)
    verb = verbs.add_parser("call", help="Call a service")
    verb.add_argument("service_name")
    verb.add_argument("service_type", help="For example std_srvs/srv/Empty")
    verb.add_argument("values", nargs="?", default="{}", help="Values of the request, in YAML")
    verb.set_defaults(main=_call)


def _list(arguments: argparse.Namespace) -> None:
    with command_node(arguments.spin_time) as node:
        for name, types in node.get_service_names_and_types():
            if not is_hidden(name):
                print(f"{name} [{', '.join(types)}]" if arguments.show_types else name)


def _call(arguments: argparse.Namespace) -> None:
    with command_node() as node:
        service = import_type(arguments.service_type)
        if not hasattr(service, "Request"):
            raise CommandError(f"The passed service type is invalid: {arguments.service_type}")
        request = fill(service.Request(), parse_values(arguments.values))
        client = node.create_client(service, arguments.service_name)
        if not client.service_is_ready():
            print("waiting for service to become available...", flush=True)
            client.wait_for_service()
        print(f"requester: making request: {request!r}\n", flush=True)
        future = client.call_async(request)
        rclpy.spin_until_future_complete(node, future)
        if future.done():
            print(f"response:\n{future.result()!r}\n")
