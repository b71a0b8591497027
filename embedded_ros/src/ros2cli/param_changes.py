"""``ros2 param`` as far as it changes parameters: set, load, delete.

What a node refuses goes to standard error, and the exit code is 0: that is so in Jazzy.
"""

import argparse
import sys
from typing import Any

import yaml

from rcl_interfaces.msg import Parameter
from rclpy.parameter import get_parameter_value, parameter_dict_from_yaml_file
from ros2cli.errors import CommandError
from ros2cli.remote_parameters import parameters_of_node

__all__ = ["delete", "load", "set_value"]


def _tell(result: Any, done: str, refused: str) -> None:
    reason = f": {result.reason}" if result.reason else ""
    if result.successful:
        print(f"{done}{reason}")
    else:
        print(f"{refused}{reason}", file=sys.stderr)


def set_value(arguments: argparse.Namespace) -> None:
    """``param set``."""
    value = get_parameter_value(arguments.value)
    wanted = Parameter(name=arguments.parameter_name, value=value)
    with parameters_of_node(arguments) as parameters:
        (result,) = parameters.set([wanted])
    _tell(result, "Set parameter successful", "Setting parameter failed")


def delete(arguments: argparse.Namespace) -> None:
    """``param delete``."""
    with parameters_of_node(arguments) as parameters:
        result = parameters.delete(arguments.parameter_name)
    _tell(result, "Deleted parameter successfully", "Deleting parameter failed")


def load(arguments: argparse.Namespace) -> None:
    """``param load``."""
    wanted = _parameters_in(arguments.parameter_file, for_all_nodes=not arguments.no_use_wildcard)
    with parameters_of_node(arguments) as parameters:
        results = parameters.set(wanted)
    for parameter, result in zip(wanted, results, strict=True):
        name = parameter.name
        _tell(result, f"Set parameter {name} successful", f"Set parameter {name} failed")


def _parameters_in(path: str, *, for_all_nodes: bool) -> list[Any]:
    try:
        return list(parameter_dict_from_yaml_file(path, for_all_nodes).values())
    except OSError as error:
        raise CommandError(error) from None
    except (UnicodeDecodeError, yaml.YAMLError) as error:
        raise CommandError(f"{path} is not valid YAML: {error}") from None
    except (RuntimeError, TypeError, ValueError) as error:
        raise CommandError(f"{path} is no parameter file: {error}") from None
