"""``ros2 param``: the parameters of nodes."""

import argparse
import re
import sys
from typing import Any

import yaml

import rclpy
from rclpy.node import Node
from rclpy.parameter import (
    PARAMETER_SEPARATOR_STRING,
    Parameter,
    get_parameter_value,
    parameter_dict_from_yaml_file,
    parameter_value_to_python,
)
from rclpy.parameter_client import AsyncParameterClient
from ros2cli.errors import CommandError
from ros2cli.node_session import (
    add_group,
    add_node_arguments,
    command_node,
    is_hidden,
    spin_until,
    wait_for_node_names,
)

__all__ = ["add_commands"]

_SERVICE_TIMEOUT_S = 5.0
#: Sentence and name of each type.
_TYPES = {
    Parameter.Type.NOT_SET: ("Parameter not set.", "not set"),
    Parameter.Type.BOOL: ("Boolean value is:", "boolean"),
    Parameter.Type.INTEGER: ("Integer value is:", "integer"),
    Parameter.Type.DOUBLE: ("Double value is:", "double"),
    Parameter.Type.STRING: ("String value is:", "string"),
    Parameter.Type.BYTE_ARRAY: ("Byte values are:", "byte array"),
    Parameter.Type.BOOL_ARRAY: ("Boolean values are:", "boolean array"),
    Parameter.Type.INTEGER_ARRAY: ("Integer values are:", "integer array"),
    Parameter.Type.DOUBLE_ARRAY: ("Double values are:", "double array"),
    Parameter.Type.STRING_ARRAY: ("String values are:", "string array"),
}


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    verbs = add_group(groups, "param", "Various param related sub-commands")
    added = {}
    for name, function, description, operands in (
        ("delete", _delete, "Delete parameter", ("parameter_name",)),
        ("describe", _describe, "Show descriptive information about declared parameters", ()),
        ("dump", _dump, "Show all of the parameters of a node in a YAML file format", ()),
        ("get", _get, "Get parameter", ("parameter_name",)),
        ("list", _list, "Output a list of available parameters", ()),
        ("load", _load, "Load parameter file for a node", ("parameter_file",)),
        ("set", _set, "Set parameter", ("parameter_name", "value")),
    ):
        verb = added[name] = verbs.add_parser(name, help=description)
        verb.add_argument("node_name", nargs="?" if name == "list" else None)
        for operand in operands:
            verb.add_argument(operand)
        verb.add_argument(
            "--timeout",
            metavar="N",
            type=float,
            default=1.0,
            help="Wait for N seconds until node becomes available (default: %(default)g)",
        )
        add_node_arguments(verb)
        verb.set_defaults(main=function)
    added["describe"].add_argument("parameter_names", nargs="+")
    added["get"].add_argument("--hide-type", action="store_true", help="Hide the type information")
    listing = added["list"]
    listing.add_argument("--filter", metavar="REGEX", help="Only list parameters that match")
    listing.add_argument(
        "--param-prefixes", nargs="+", default=[], help="Only list parameters with these prefixes"
    )
    listing.add_argument("--param-type", action="store_true", help="Print parameter types")
    added["load"].add_argument(
        "--no-use-wildcard", action="store_true", help="Do not load parameters of '/**'"
    )


def _full_name(name: str) -> str:
    return f"/{name.lstrip('/')}"


def _client(node: Node, arguments: argparse.Namespace) -> AsyncParameterClient:
    """Client of the node that the command names, once it is there."""
    name = _full_name(arguments.node_name)
    if not spin_until(
        node, lambda: name in node.get_fully_qualified_node_names(), arguments.timeout
    ):
        raise CommandError("Node not found")
    return _ready_client(node, name)


def _ready_client(node: Node, name: str) -> AsyncParameterClient:
    client = AsyncParameterClient(node, name)
    if not client.wait_for_services(_SERVICE_TIMEOUT_S):
        raise CommandError(
            f"Wait for service timed out waiting for parameter services for node {name}"
        )
    return client


def _result(node: Node, future: Any) -> Any:
    rclpy.spin_until_future_complete(node, future, timeout_sec=_SERVICE_TIMEOUT_S)
    if not future.done():
        raise CommandError(f"The node did not answer within {_SERVICE_TIMEOUT_S:g} seconds")
    return future.result()


def _list(arguments: argparse.Namespace) -> None:
    try:
        pattern = re.compile(arguments.filter or "")
    except re.error as error:
        raise CommandError(f"Invalid filter '{arguments.filter}': {error}") from None
    with command_node(0.0 if arguments.node_name else arguments.spin_time) as node:
        if arguments.node_name:
            _print_names(node, _client(node, arguments), arguments, pattern, title=None)
            return
        wait_for_node_names(node)
        for name in sorted(set(node.get_fully_qualified_node_names())):
            if is_hidden(name):
                continue
            client = AsyncParameterClient(node, name)
            if client.wait_for_services(_SERVICE_TIMEOUT_S):
                _print_names(node, client, arguments, pattern, title=name)
            else:
                print(f"Wait for service timed out waiting for parameter services for node {name}")


def _print_names(
    node: Node,
    client: AsyncParameterClient,
    arguments: argparse.Namespace,
    pattern: re.Pattern[str],
    title: str | None,
) -> None:
    found = _result(node, client.list_parameters(arguments.param_prefixes or None)).result.names
    names = sorted(name for name in found if pattern.match(name))
    if title and names:
        print(f"{title}:")
    types = {}
    if arguments.param_type and names:
        descriptors = _result(node, client.describe_parameters(names)).descriptors
        types = {item.name: f" (type: {_type_name(item.type)})" for item in descriptors}
    for name in names:
        print(f"  {name}{types.get(name, '')}")


def _type_name(number: int) -> str:
    return _TYPES[Parameter.Type(number)][1]


def _get(arguments: argparse.Namespace) -> None:
    with command_node() as node:
        client = _client(node, arguments)
        values = _result(node, client.get_parameters([arguments.parameter_name])).values
    if not values:
        raise CommandError("Parameter not set")
    value = parameter_value_to_python(values[0])
    sentence = _TYPES[Parameter.Type(values[0].type)][0]
    if arguments.hide_type:
        print(value)
    elif value is None:
        print(sentence)
    else:
        print(sentence, value)


def _set(arguments: argparse.Namespace) -> None:
    from rcl_interfaces.msg import Parameter as ParameterMsg

    value = get_parameter_value(arguments.value)
    parameter = ParameterMsg(name=arguments.parameter_name, value=value)
    with command_node() as node:
        client = _client(node, arguments)
        result = _result(node, client.set_parameters([parameter])).results[0]
    _report("Set parameter successful", "Setting parameter failed", result)


def _delete(arguments: argparse.Namespace) -> None:
    with command_node() as node:
        client = _client(node, arguments)
        result = _result(node, client.delete_parameters([arguments.parameter_name])).results[0]
    _report("Deleted parameter successfully", "Deleting parameter failed", result)


def _report(success: str, failure: str, result: Any) -> None:
    """Print a result. Jazzy's exit code is 0 either way, so ours is, too."""
    reason = f": {result.reason}" if result.reason else ""
    if result.successful:
        print(f"{success}{reason}")
    else:
        print(f"{failure}{reason}", file=sys.stderr)


def _describe(arguments: argparse.Namespace) -> None:
    with command_node() as node:
        client = _client(node, arguments)
        found = _result(node, client.describe_parameters(arguments.parameter_names)).descriptors
    for descriptor in found:
        print(f"Parameter name: {descriptor.name}")
        print(f"  Type: {_type_name(descriptor.type)}")
        if descriptor.description:
            print(f"  Description: {descriptor.description}")
        print("  Constraints:")
        if descriptor.read_only:
            print("    Read only: true")
        for limit in [*descriptor.floating_point_range, *descriptor.integer_range][:1]:
            print(f"    Min value: {limit.from_value}")
            print(f"    Max value: {limit.to_value}")
            if limit.step:
                print(f"    Step: {limit.step}")
        if descriptor.additional_constraints:
            print(f"    Additional constraints: {descriptor.additional_constraints}")


def _dump(arguments: argparse.Namespace) -> None:
    with command_node() as node:
        client = _client(node, arguments)
        names = sorted(_result(node, client.list_parameters()).result.names)
        values = _result(node, client.get_parameters(names)).values
    tree: dict[str, Any] = {}
    for name, value in zip(names, values, strict=False):
        branch = tree
        *parents, leaf = name.split(PARAMETER_SEPARATOR_STRING)
        for parent in parents:
            branch = branch.setdefault(parent, {})
        branch[leaf] = parameter_value_to_python(value)
    content = {_full_name(arguments.node_name): {"ros__parameters": tree}}
    print(yaml.dump(content, default_flow_style=False))


def _load(arguments: argparse.Namespace) -> None:
    try:
        parameters = list(
            parameter_dict_from_yaml_file(
                arguments.parameter_file, not arguments.no_use_wildcard
            ).values()
        )
    except OSError as error:
        raise CommandError(str(error)) from None
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        reason = " ".join(str(error).split())
        raise CommandError(f"{arguments.parameter_file} is not valid YAML: {reason}") from None
    with command_node() as node:
        client = _client(node, arguments)
        results = _result(node, client.set_parameters(parameters)).results
    for parameter, result in zip(parameters, results, strict=True):
        name = parameter.name
        _report(f"Set parameter {name} successful", f"Set parameter {name} failed", result)
