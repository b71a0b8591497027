"""The parameters of a node that runs elsewhere, asked over its services."""

import argparse
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.parameter_client import AsyncParameterClient
from ros2cli.errors import CommandError, did_you_mean
from ros2cli.node_session import command_node, wait_until

__all__ = ["RemoteParameters", "full_node_name", "parameters_of_node"]

#: How long the services of a node may take to appear, and then to answer.
_SERVICE_S = 5.0


class RemoteParameters:
    """Questions to a node, each waited for.

    Parameters
    ----------
    node : Node
        That of the command.
    name : str
        Full name of the node that is asked.

    Raises
    ------
    CommandError
        If that node has no parameter services; of each method, if it does not answer.
    """

    def __init__(self, node: Node, name: str) -> None:
        self._node = node
        self._name = name
        self._services = AsyncParameterClient(node, name)
        if not self._services.wait_for_services(_SERVICE_S):
            raise CommandError(f"{name} offers no parameter services")

    def _answer(self, future: Any) -> Any:
        rclpy.spin_until_future_complete(self._node, future, timeout_sec=_SERVICE_S)
        if not future.done():
            raise CommandError(f"{self._name} did not answer within {_SERVICE_S:g} s")
        return future.result()

    def names(self, prefixes: Sequence[str] = ()) -> list[str]:
        """Names of the parameters that are set, sorted."""
        answer = self._answer(self._services.list_parameters(list(prefixes) or None))
        return sorted(answer.result.names)

    def values(self, names: Sequence[str]) -> list[Any]:
        """ParameterValue messages; none if the node does not know one of the names."""
        return list(self._answer(self._services.get_parameters(list(names))).values)

    def descriptors(self, names: Sequence[str]) -> list[Any]:
        """ParameterDescriptor messages; none if the node does not know one of the names."""
        return list(self._answer(self._services.describe_parameters(list(names))).descriptors)

    def set(self, parameters: Iterable[Any]) -> list[Any]:
        """SetParametersResult messages, one a parameter."""
        return list(self._answer(self._services.set_parameters(list(parameters))).results)

    def delete(self, name: str) -> Any:
        """SetParametersResult message."""
        return self._answer(self._services.delete_parameters([name])).results[0]

    def unknown(self, names: Sequence[str]) -> CommandError:
        """Complaint about names of which the node does not know all."""
        known = self.names()
        strange = [name for name in names if name not in known]
        near = did_you_mean(strange[0], known) if strange else ""
        which = f": {', '.join(strange)}" if len(names) > 1 else ""
        return CommandError(f"Parameter not set{which}{near}")


def full_node_name(name: str) -> str:
    """Name of a node from its first slash on."""
    return f"/{name.lstrip('/')}"


@contextmanager
def parameters_of_node(arguments: argparse.Namespace) -> Iterator[RemoteParameters]:
    """Wait for the node that the command line names, and ask it."""
    name = full_node_name(arguments.node_name)
    with command_node() as node:
        if not wait_until(
            node, lambda: name in node.get_fully_qualified_node_names(), arguments.timeout
        ):
            near = did_you_mean(name, node.get_fully_qualified_node_names())
            raise CommandError(f"Node not found{near}")
        yield RemoteParameters(node, name)
