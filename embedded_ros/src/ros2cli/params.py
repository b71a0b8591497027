"""``ros2 param`` as far as it reads: get, list, describe, dump."""

import argparse
import re
import sys
from typing import Any

import yaml

from rclpy.parameter import PARAMETER_SEPARATOR_STRING, Parameter, parameter_value_to_python
from ros2cli.errors import CommandError
from ros2cli.graph import is_hidden, node_names
from ros2cli.node_session import command_node
from ros2cli.remote_parameters import RemoteParameters, full_node_name, parameters_of_node

__all__ = ["describe", "dump", "get", "show_names"]


def _type_name(number: int) -> str:
    """Type as ``param list`` and ``param describe`` call it: ``double array``, ``boolean``."""
    return Parameter.Type(number).name.lower().replace("_", " ").replace("bool", "boolean")


def _sentence(number: int) -> str:
    """What ``param get`` puts before a value: ``Double values are:`` for an array of doubles."""
    kind = _type_name(number).capitalize()
    element = kind.removesuffix(" array")
    return f"{element} value is:" if element == kind else f"{element} values are:"


def get(arguments: argparse.Namespace) -> None:
    """``param get``."""
    name = arguments.parameter_name
    with parameters_of_node(arguments) as parameters:
        values = parameters.values([name])
        if not values:
            raise parameters.unknown([name])
    (message,) = values
    value = parameter_value_to_python(message)
    if arguments.hide_type:
        print(value)
    elif value is None:
        print("Parameter not set.")
    else:
        print(_sentence(message.type), value)


def show_names(arguments: argparse.Namespace) -> None:
    """``param list``."""
    try:
        pattern = re.compile(arguments.filter or "")
    except re.error as error:
        text = f"--filter '{arguments.filter}' is no regular expression: {error}"
        raise CommandError(text) from None
    if arguments.node_name:
        with parameters_of_node(arguments) as parameters:
            _print(_lines(parameters, pattern, arguments))
        return
    with command_node(arguments.spin_time) as node:
        for name in sorted(set(node_names(node))):
            if is_hidden(name):
                continue
            try:
                lines = _lines(RemoteParameters(node, name), pattern, arguments)
            except CommandError as error:
                # The others are shown all the same.
                print(error, file=sys.stderr)
            else:
                _print([f"{name}:", *lines] if lines else [])


def _lines(
    parameters: RemoteParameters, pattern: re.Pattern[str], arguments: argparse.Namespace
) -> list[str]:
    names = [name for name in parameters.names(arguments.param_prefixes) if pattern.match(name)]
    if not names or not arguments.param_type:
        return [f"  {name}" for name in names]
    return [
        f"  {item.name} (type: {_type_name(item.type)})" for item in parameters.descriptors(names)
    ]


def _print(lines: list[str]) -> None:
    for line in lines:
        print(line)


def describe(arguments: argparse.Namespace) -> None:
    """``param describe``."""
    names = arguments.parameter_names
    with parameters_of_node(arguments) as parameters:
        found = parameters.descriptors(names)
        if len(found) < len(names):
            raise parameters.unknown(names)
    for item in found:
        # There is one range at most.
        limits = [*item.floating_point_range, *item.integer_range][:1]
        print(f"Parameter name: {item.name}")
        print(f"  Type: {_type_name(item.type)}")
        _print_if(item.description, "  Description", item.description)
        print("  Constraints:")
        _print_if(item.read_only, "    Read only", "true")
        for limit in limits:
            print(f"    Min value: {limit.from_value}")
            print(f"    Max value: {limit.to_value}")
            _print_if(limit.step, "    Step", limit.step)
        more = item.additional_constraints
        _print_if(more, "    Additional constraints", more)


def _print_if(there: object, title: str, value: object) -> None:
    if there:
        print(f"{title}: {value}")


def dump(arguments: argparse.Namespace) -> None:
    """``param dump``."""
    with parameters_of_node(arguments) as parameters:
        names = parameters.names()
        values = [parameter_value_to_python(value) for value in parameters.values(names)]
    # A parameter that went away in between takes the values of all with it.
    if len(values) < len(names):
        raise CommandError("The node's parameters changed while they were asked for; try again")
    tree = _tree(dict(zip(names, values, strict=True)))
    content = {full_node_name(arguments.node_name): {"ros__parameters": tree}}
    print(yaml.dump(content, default_flow_style=False))


def _tree(values: dict[str, Any]) -> dict[str, Any]:
    """Nest sorted names at their dots; below a name that has a value itself the dots stay."""
    tree: dict[str, Any] = {}
    for name, value in values.items():
        branch, rest = tree, name
        while PARAMETER_SEPARATOR_STRING in rest:
            first, _, below = rest.partition(PARAMETER_SEPARATOR_STRING)
            if not isinstance(branch.setdefault(first, {}), dict):
                break
            branch, rest = branch[first], below
        branch[rest] = value
    return tree
