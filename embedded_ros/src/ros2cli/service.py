"""``ros2 service``: services and calls of them."""

import argparse
from typing import Any

import rclpy
from rclpy.node import Node
from ros2cli.errors import CommandError
from ros2cli.messages import fill, import_type, parse_values
from ros2cli.node_session import (
    add_group,
    add_node_arguments,
    command_node,
    is_hidden,
    spin_until,
)
from ros2cli.number_arguments import positive_float

__all__ = ["add_commands"]


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    verbs = add_group(groups, "service", "Various service related sub-commands")
    verb = verbs.add_parser("call", help="Call a service")
    verb.add_argument("service_name")
    verb.add_argument("service_type", help="For example std_srvs/srv/Empty")
    verb.add_argument("values", nargs="?", default="{}", help="Values of the request, in YAML")
    verb.add_argument(
        "-r", "--rate", metavar="N", type=positive_float, help="Repeat the call at a rate in Hz"
    )
    verb.set_defaults(main=_call)
    verb = verbs.add_parser("find", help="Output a list of available services of a given type")
    verb.add_argument("service_type")
    _add_list_arguments(verb)
    verb.set_defaults(main=_find)
    verb = verbs.add_parser("info", help="Print information about a service")
    verb.add_argument("service_name")
    add_node_arguments(verb)
    verb.set_defaults(main=_info)
    verb = verbs.add_parser("list", help="Output a list of available services")
    verb.add_argument("-t", "--show-types", action="store_true", help="Additionally show the type")
    _add_list_arguments(verb)
    verb.set_defaults(main=_list)
    verb = verbs.add_parser("type", help="Output a service's type")
    verb.add_argument("service_name")
    add_node_arguments(verb)
    verb.set_defaults(main=_type)


def _add_list_arguments(verb: argparse.ArgumentParser) -> None:
    verb.add_argument("-c", "--count-services", action="store_true", help="Only display the number")
    verb.add_argument(
        "--include-hidden-services", action="store_true", help="Consider hidden services as well"
    )
    add_node_arguments(verb)


def _services(arguments: argparse.Namespace) -> list[tuple[str, list[str]]]:
    with command_node(arguments.spin_time) as node:
        own = f"{node.get_fully_qualified_name()}/"
        return [
            (name, types)
            for name, types in node.get_service_names_and_types()
            if not name.startswith(own)
            and (arguments.include_hidden_services or not is_hidden(name))
        ]


def _list(arguments: argparse.Namespace) -> None:
    services = _services(arguments)
    if arguments.count_services:
        print(len(services))
        return
    for name, types in services:
        print(f"{name} [{', '.join(types)}]" if arguments.show_types else name)


def _find(arguments: argparse.Namespace) -> None:
    names = [name for name, types in _services(arguments) if arguments.service_type in types]
    if arguments.count_services:
        print(len(names))
        return
    for name in names:
        print(name)


def _type(arguments: argparse.Namespace) -> int:
    with command_node(arguments.spin_time) as node:
        types = dict(node.get_service_names_and_types()).get(arguments.service_name, [])
    for type_name in types:
        print(type_name)
    return 0 if types else 1


def _info(arguments: argparse.Namespace) -> None:
    name = arguments.service_name
    with command_node(arguments.spin_time) as node:
        types = dict(node.get_service_names_and_types()).get(name)
        if types is None:
            raise CommandError(f"Unknown service '{name}'")
        print("Type:", types[0] if len(types) == 1 else types)
        print("Clients count:", node.count_clients(name))
        print("Services count:", node.count_services(name))


def _call(arguments: argparse.Namespace) -> None:
    service = import_type(arguments.service_type, "srv", _complaint(arguments.service_type))
    values = parse_values(arguments.values)
    request = service.Request()
    fill(request, values)
    with command_node() as node:
        client = node.create_client(service, arguments.service_name)
        if not client.service_is_ready():
            print("waiting for service to become available...", flush=True)
            spin_until(node, client.service_is_ready, float("inf"))
        while rclpy.ok():
            _call_once(node, client, request)
            if arguments.rate is None:
                break
            spin_until(node, lambda: False, 1.0 / arguments.rate)


def _complaint(type_name: str) -> str:
    is_message = "/msg/" in type_name
    return (
        "The passed type is not a service" if is_message else "The passed service type is invalid"
    )


def _call_once(node: Node, client: Any, request: Any) -> None:
    print(f"requester: making request: {request!r}\n", flush=True)
    future = client.call_async(request)
    rclpy.spin_until_future_complete(node, future)
    if future.done():
        print(f"response:\n{future.result()!r}\n", flush=True)
