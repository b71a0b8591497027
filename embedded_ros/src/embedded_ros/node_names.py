"""Names: the part of :class:`rclpy.node.Node` that applies the command line's arguments."""

from __future__ import annotations

from embedded_ros.errors import RCLError, RCLInvalidROSArgsError
from embedded_ros.names import IS_INVALID, expand, expand_valid, full_topic_name_error, join
from embedded_ros.parameter_value import Parameter
from embedded_ros.ros_arguments import (
    NO_ARGUMENTS,
    RosArguments,
    parameter_overrides,
    parse_arguments,
)
from rclpy.context import Context
from rclpy.validate_namespace import validate_namespace
from rclpy.validate_node_name import validate_node_name

__all__ = ["NodeNames"]


class NodeNames:
    """Name and namespace, and what arguments of the command line say of them and of others."""

    def _init_names(
        self,
        context: Context,
        cli_args: list[str] | None,
        node_name: str,
        namespace: str | None,
        *,
        use_global_arguments: bool,
    ) -> None:
        self._arguments = _arguments_for_node(context, cli_args, use_global_arguments)
        self._name, self._namespace = self._resolve_own_name(node_name, namespace or "")

    def _resolve_own_name(self, name: str, namespace: str) -> tuple[str, str]:
        namespace = namespace if namespace.startswith("/") else f"/{namespace}"
        validate_node_name(name)
        validate_namespace(namespace)
        for arguments in self._arguments:
            new_name = arguments.node_name(name)
            if new_name is not None:
                validate_node_name(new_name)
                name = new_name
                break
        for arguments in self._arguments:
            new_namespace = arguments.namespace(name)  # of the new name, as rcl has it
            if new_namespace is not None:
                validate_namespace(new_namespace)
                namespace = new_namespace
                break
        return name, namespace

    def _says(self, switch: str) -> bool:
        return any(switch in arguments.switches for arguments in self._arguments)

    def _overrides(self, given: list[Parameter]) -> dict[str, Parameter]:
        values = parameter_overrides(self._arguments, self._name, self._namespace)
        overrides = {name: Parameter(name, value=value) for name, value in values.items()}
        return overrides | {parameter.name: parameter for parameter in given}

    def get_name(self) -> str:
        """Name of the node."""
        return self._name

    def get_namespace(self) -> str:
        """Namespace of the node."""
        return self._namespace

    def get_fully_qualified_name(self) -> str:
        """Namespace and name of the node."""
        return join(self._namespace, self._name)

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Expand and, unless `only_expand`, remap a topic name; ``RCLError`` if it is invalid."""
        return self._resolve_or_rcl_error(topic, only_expand, is_service=False)

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Expand and, unless `only_expand`, remap a service name; ``RCLError`` if it is invalid."""
        return self._resolve_or_rcl_error(service, only_expand, is_service=True)

    def _resolve_or_rcl_error(self, name: str, only_expand: bool, *, is_service: bool) -> str:
        try:
            full_name = expand(name, self._name, self._namespace)
        except ValueError as error:
            reason = str(error).partition(IS_INVALID)[2]
            raise RCLError(f"failed to resolve name: {reason}") from None
        fault = full_topic_name_error(full_name)
        if fault is not None:
            raise RCLError(f"failed to resolve name: {fault[0]}")
        return full_name if only_expand else self._remapped(full_name, is_service=is_service)

    def _resolve(self, name: str, *, is_service: bool = False) -> str:
        full_name = expand_valid(name, self._name, self._namespace, is_service=is_service)
        return self._remapped(full_name, is_service=is_service)

    def _remapped(self, full_name: str, *, is_service: bool) -> str:
        for arguments in self._arguments:
            replacement = arguments.remap(
                full_name, self._name, self._namespace, is_service=is_service
            )
            if replacement is not None:
                return replacement
        return full_name


def _arguments_for_node(
    context: Context, cli_args: list[str] | None, use_global: bool
) -> tuple[RosArguments, ...]:
    """Arguments that apply to a node, its own ones first."""
    own = NO_ARGUMENTS
    if cli_args:
        try:
            own = parse_arguments(cli_args)
        except RCLInvalidROSArgsError as error:
            raise RCLInvalidROSArgsError(f"Failed to parse ROS arguments: {error}") from None
    return (own, context._arguments) if use_global else (own,)
