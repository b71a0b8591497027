"""ROS parameter files: for which nodes their sections are, and what these set.

rcl drops sections for other nodes, and names that a node does not know, without a word.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import yaml

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_tables import (
    ParameterTable,
    check_value,
    full_name,
    known_parameters,
    suggestion,
)

PARAMETERS_KEY = "ros__parameters"

ROS_PARAMETERS = ("use_sim_time", "start_type_description_service")
"""Parameters that every node has, beside those of its QoS."""


def read_sections(label: str, path: Path) -> dict[str, Any]:
    """Return what stands in a parameter file below each node's name or pattern.

    Parameters
    ----------
    label : str
        What the messages call the file, for example ``--config FILE``.
    path : Path
        The file.

    Raises
    ------
    BadInputError
        If it cannot be read, is not YAML, or holds no mapping.
    """
    if path.is_char_device() or path.is_block_device():
        raise BadInputError(f"{label}: is a device: must be a file")
    document = _parsed(label, path, yaml.safe_load)
    if not isinstance(document, dict) or not document:
        raise no_parameter_file(label)
    return {str(section): content for section, content in document.items()}


def no_parameter_file(label: str) -> BadInputError:
    """Return the error of a file that is YAML, but no parameter file."""
    return BadInputError(f"{label}: must be a ROS parameter file with nodes")


def checked_parameters(
    label: str,
    parameters: Any,
    table: ParameterTable,
    *,
    for_all: bool,
    free_prefix: str | None = None,
) -> dict[str, Any]:
    """Return by flat name what a section sets for a node, each value checked.

    Parameters
    ----------
    label : str
        What the messages call the section.
    parameters : Any
        What stands below ``ros__parameters``.
    table : ParameterTable
        Parameters of the node.
    for_all : bool
        Whether the section is for all nodes: what others have is left out then.
    free_prefix : str, optional
        Beginning of names that only somebody's own code knows, for example ``drive.``.

    Raises
    ------
    BadInputError
        For a value that is not allowed, and for a name that the node does not know.
    """
    known, values = known_parameters(table), {}
    for name, value in _flat(parameters):
        if name in known:
            check_value(f"{label}: {name}", value, *known[name])
        elif free_prefix is not None and name.startswith(free_prefix):
            values[name] = value
        elif name not in ROS_PARAMETERS and not name.startswith("qos_overrides."):
            if for_all:
                continue
            raise BadInputError(
                f"{label}: {name} = {value!r}: is not a parameter of this node"
                f"{suggestion(name, known)}"
            )
        values[name] = value
    return values


def _flat(parameters: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Iterate over the values of nested mappings with their full names."""
    if not isinstance(parameters, dict):
        yield prefix, parameters
        return
    for name, value in parameters.items():
        yield from _flat(value, full_name(prefix, str(name)))


def _parsed(label: str, path: Path, parse: Callable[[str], Any]) -> Any:
    """Return what a parser of YAML makes of a file."""
    try:
        return parse(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInputError(f"{label}: cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise BadInputError(f"{label}: cannot be read: {error}") from error
    except yaml.YAMLError as error:
        raise BadInputError(f"{label}: is not YAML: {error}") from error


def sections(path: str | Path) -> list[str]:
    """Return the sections of a parameter file: names and patterns of nodes, as they are written.

    Parameters
    ----------
    path : str or Path
        The file.

    Raises
    ------
    BadInputError
        If it cannot be read or is not YAML.
    """
    # Not loaded: rcl takes values that another parser may refuse.
    root = _parsed(
        f"parameter file {path}", Path(path), partial(yaml.compose, Loader=yaml.SafeLoader)
    )
    return list(_sections(root, ""))


def _sections(node: yaml.Node | None, prefix: str) -> Iterator[str]:
    if not isinstance(node, yaml.MappingNode):
        return
    for key, value in node.value:
        if key.value == PARAMETERS_KEY:
            yield prefix
        else:
            yield from _sections(
                value, f"{prefix.rstrip('/')}/{key.value}" if prefix else key.value
            )


def is_for(section: str, node: str) -> bool:
    """Tell whether a section of a parameter file is for a node.

    Parameters
    ----------
    section : str
        ``twin``, ``/left/twin`` or a pattern: ``*`` is one token of a name, ``**`` any number.
    node : str
        Fully qualified name, for example ``/left/twin``.
    """
    tokens = {"*": r"/\w+", "**": r"(/\w+)*"}
    pattern = "".join(
        tokens.get(token, f"/{re.escape(token)}") for token in section.strip("/").split("/")
    )
    return re.fullmatch(pattern, node) is not None


def unused_files(arguments: Sequence[str], *nodes: str) -> list[str]:
    """Return a line for each parameter file on a command line that holds nothing for its nodes.

    Parameters
    ----------
    arguments : sequence of str
        Command line of the nodes' process, ROS arguments included.
    *nodes : str
        Fully qualified names of the nodes, mostly of one.

    Raises
    ------
    BadInputError
        If a file cannot be read or is not YAML.
    """
    names = " or ".join(nodes)
    possible = " or ".join(f"/**/{node.rpartition('/')[2]}" for node in nodes)
    lines = []
    for path in _parameter_files(arguments):
        found = sections(path)
        if any(is_for(section, node) for section in found for node in nodes):
            continue
        has = f"its sections are {', '.join(found)}" if found else "it has no sections"
        lines.append(
            f"parameter file {path}: holds nothing for {names}, {has}; "
            f"a section {possible} is for this node in any namespace"
        )
    return lines


def _parameter_files(arguments: Sequence[str]) -> Iterator[str]:
    is_ros, is_file = False, False
    for word in arguments:
        if is_file:
            yield word
        is_file = is_ros and not is_file and word == "--params-file"
        if word in ("--ros-args", "--"):
            is_ros = word == "--ros-args"
