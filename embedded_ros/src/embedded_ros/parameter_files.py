"""Parameters as command lines and files of other programs write them, for a request to a node.

What a node itself reads of its command line goes by rcl's rules, which are not those of YAML: see
:mod:`embedded_ros.yaml_values`. Every program that has parameters imports this module, few have a
text for it: PyYAML is imported with the first one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from embedded_ros.message_classes import message_class
from embedded_ros.parameter_selection import SEPARATOR
from embedded_ros.parameter_type import ParameterType, value_field
from embedded_ros.parameter_value import Parameter

__all__ = ["get_parameter_value", "parameter_dict_from_yaml_file", "parameter_value_to_python"]

_ANY_NODE = "/**"
_CONTENT = "ros__parameters"


def get_parameter_value(string_value: str) -> Any:
    """Make an ``rcl_interfaces.msg.ParameterValue`` of a text: YAML where that gives a value."""
    import yaml

    try:
        value = yaml.safe_load(string_value)
        type_ = ParameterType.from_parameter_value(value)
    except (yaml.YAMLError, TypeError):
        value, type_ = None, ParameterType.NOT_SET
    if value == []:
        type_ = ParameterType.BOOL_ARRAY  # so do other programs, who try this type first
    elif type_ in (ParameterType.NOT_SET, ParameterType.BYTE_ARRAY):
        type_, value = ParameterType.STRING, string_value
    return Parameter("", type_, value).get_parameter_value()


def parameter_value_to_python(parameter_value: Any) -> Any:
    """Value of an ``rcl_interfaces.msg.ParameterValue``; None if not set.

    Raises
    ------
    RuntimeError
        If its type is none.
    """
    try:
        field = value_field(parameter_value.type)
    except ValueError:
        raise RuntimeError(f"unexpected parameter type {parameter_value.type}") from None
    if field is None:
        return None
    value = getattr(parameter_value, field)
    return value if isinstance(value, bool | int | float | str) else list(value)


def parameter_dict_from_yaml_file(
    parameter_file: str,
    use_wildcard: bool = False,
    target_nodes: list[str] | None = None,
    namespace: str = "",
) -> dict[str, Any]:
    """Read a parameter file.

    Parameters
    ----------
    parameter_file : str
    use_wildcard : bool
        Whether to take the parameters of ``/**``, too; those of a node win.
    target_nodes : list of str, optional
        Nodes of the file whose parameters to take; all by default.
    namespace : str
        Put before every parameter name.

    Returns
    -------
    dict
        ``rcl_interfaces.msg.Parameter`` by name.

    Raises
    ------
    RuntimeError
        If the file is no parameter file or lacks a node.
    """
    import yaml

    with Path(parameter_file).open(encoding="utf-8") as stream:
        sections = yaml.safe_load(stream) or {}
    if not isinstance(sections, Mapping):
        raise RuntimeError(f"YAML file is not a valid ROS parameter file: {parameter_file}")
    wanted = target_nodes or [node for node in sections if node != _ANY_NODE]
    missing = [node for node in wanted if node not in sections]
    if missing:
        raise RuntimeError(
            f"Param file does not contain parameters for {missing[0]},"
            f"only for nodes: {list(sections)} "
        )
    if use_wildcard and _ANY_NODE in sections:
        wanted = [_ANY_NODE, *wanted]
    if not wanted:
        raise RuntimeError("Param file does not contain selected parameters")
    tree: dict[str, Any] = {}
    for node in wanted:
        section = sections[node]
        if not isinstance(section, Mapping) or _CONTENT not in section:
            raise RuntimeError(f"YAML file is not a valid ROS parameter file for node {node}")
        tree |= section[_CONTENT]
    message = message_class("rcl_interfaces/msg/Parameter")
    return {
        name: message(name=name, value=get_parameter_value(str(value)))
        for name, value in _leaves(tree, namespace)
    }


def _leaves(tree: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    """Full names and values of what a tree of parameters holds."""
    for key, value in tree.items():
        if isinstance(value, Mapping):
            yield from _leaves(value, f"{prefix}{key}{SEPARATOR}")
        else:
            yield f"{prefix}{key}", value
