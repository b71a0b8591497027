"""``ros2 param``: the parameters of nodes."""

import argparse
from typing import Any

import yaml

import rclpy
from rclpy.node import Node
from rclpy.parameter import Parameter, get_parameter_value, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from ros2cli.errors import CommandError
from ros2cli.node_session import add_spin_time, command_node, is_hidden

__all__ = ["add_commands"]

_TIMEOUT_S = 5.0
_TITLES = {
    Parameter.Type.NOT_SET: "Parameter not set.",
    Parameter.Type.BOOL: "Boolean value is:",
    Parameter.Type.INTEGER: "Integer value is:",
    Parameter.Type.DOUBLE: "Double value is:",
    Parameter.Type.STRING: "String value is:",
    Parameter.Type.BYTE_ARRAY: "Byte values are:",
    Parameter.Type.BOOL_ARRAY: "Boolean values are:",
    Parameter.Type.INTEGER_ARRAY: "Integer values are:",
    Parameter.Type.DOUBLE_ARRAY: "Double values are:",
    Parameter.Type.STRING_ARRAY: "String values are:",
}


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    group = groups.add_parser("param", help="Various param related sub-commands")
    verbs = group.add_subparsers(title="Commands", required=True)
    for name, function, description, operands in (
        ("list", _list, "Output a list of available parameters", ()),
        ("get", _get, "Get parameter", ("parameter_name",)),
        ("set", _set, "Set parameter", ("parameter_name", "value")),
        ("describe", _describe, "Show descriptive information", ("parameter_name",)),
        ("dump", _dump, "Show all of the parameters of a node in a YAML file format", ()),
        ("load", _load, "Load parameter file for a node", ("parameter_file",)),
    ):
        verb = verbs.add_parser(name, help=description)
        verb.add_argument("node_name", nargs="?" if name == "list" else None)
        for operand in operands:
            verb.add_argument(operand)
        add_spin_time(verb)
        verb.set_defaults(main=function)


def _client(node: Node, name: str) -> AsyncParameterClient:
    client = AsyncParameterClient(node, f"/{name.lstrip('/')}")
    if not client.wait_for_services(_TIMEOUT_S):
        raise CommandError("Node not found")
    return client


def _result(node: Node, future: Any) -> Any:
    rclpy.spin_until_future_complete(node, future, timeout_sec=_TIMEOUT_S)
    if not future.done():
        raise CommandError(f"The node did not answer within {_TIMEOUT_S:g} seconds")
    return future.result()


def _names(node: Node, name: str) -> list[str]:
    return sorted(_result(node, _client(node, name).list_parameters()).result.names)


def _list(arguments: argparse.Namespace) -> None:
    with command_node(0.0 if arguments.node_name else arguments.spin_time) as node:
        if arguments.node_name:
            for parameter in _names(node, arguments.node_name):
                print(f"  {parameter}")
            return
        for name in sorted(node.get_fully_qualified_node_names()):
            if not is_hidden(name):
                print(f"{name}:")
                for parameter in _names(node, name):
                    print(f"  {parameter}")


def _get(arguments: argparse.Namespace) -> None:
    with command_node() as node:
        client = _client(node, arguments.node_name)
        values = _result(node, client.get_parameters([arguments.parameter_name])).values
    if not values:
        raise CommandError("Parameter not set.")
    value = parameter_value_to_python(values[0])
    print(_TITLES[Parameter.Type(values[0].type)], "" if value is None else value)


def _set(arguments: argparse.Namespace) -> int:
    from rcl_interfaces.msg import Parameter as ParameterMsg

    parameter = ParameterMsg(
        name=arguments.parameter_name, value=get_parameter_value(arguments.value)
    )
    with command_node() as node:
        client = _client(node, arguments.node_name)
        result = _result(node, client.set_parameters([parameter])).results[0]
    if result.successful:
        print("Set parameter successful" + (f": {result.reason}" if result.reason else ""))
        return 0
    raise CommandError("Setting parameter failed" + (f": {result.reason}" if result.reason else ""))


def _describe(arguments: argparse.Namespace) -> None:
    with command_node() as node:
        client = _client(node, arguments.node_name)
        found = _result(node, client.describe_parameters([arguments.parameter_name])).descriptors
    if not found:
        raise CommandError(f"Parameter {arguments.parameter_name} not found")
    descriptor = found[0]
    type_name = Parameter.Type(descriptor.type).name.lower().replace("_", " ")
    print(f"Parameter name: {descriptor.name}")
    print(f"  Type: {type_name}")
    if descriptor.description:
        print(f"  Description: {descriptor.description}")
    limits = [*descriptor.floating_point_range, *descriptor.integer_range]
    print("  Constraints:")
    if descriptor.read_only:
        print("    Read only: true")
    for limit in limits:
        print(f"    Min value: {limit.from_value}")
        print(f"    Max value: {limit.to_value}")
        if limit.step:
            print(f"    Step: {limit.step}")
    if descriptor.additional_constraints:
        print(f"    Additional constraints: {descriptor.additional_constraints}")


def _dump(arguments: argparse.Namespace) -> None:
    with command_node() as node:
        client = _client(node, arguments.node_name)
        names = _names(node, arguments.node_name)
        values = _result(node, client.get_parameters(names)).values
    tree: dict[str, Any] = {}
    for name, value in zip(names, values, strict=False):
        branch = tree
        *parents, leaf = name.split(".")
        for parent in parents:
            branch = branch.setdefault(parent, {})
        branch[leaf] = parameter_value_to_python(value)
    content = {f"/{arguments.node_name.lstrip('/')}": {"ros__parameters": tree}}
    print(yaml.dump(content, default_flow_style=False), end="")


def _load(arguments: argparse.Namespace) -> int:
    with command_node() as node:
        client = _client(node, arguments.node_name)
        try:
            future = client.load_parameter_file(arguments.parameter_file, use_wildcard=True)
        except (OSError, RuntimeError, yaml.YAMLError) as error:
            raise CommandError(str(error)) from None
        results = _result(node, future).results
    for result in results:
        print(
            "Set parameter successful"
            if result.successful
            else f"Setting parameter failed: {result.reason}"
        )
    return 0 if all(result.successful for result in results) else 1
