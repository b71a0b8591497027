"""For which nodes the sections of a ROS parameter file are: rcl drops the others without a word."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import yaml

from bdt_msgs_py.command_errors import BadInputError

PARAMETERS_KEY = "ros__parameters"


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
    try:
        # Not loaded: rcl takes values that another parser may refuse.
        root = yaml.compose(Path(path).read_text(encoding="utf-8"), Loader=yaml.SafeLoader)
    except (OSError, UnicodeDecodeError) as error:
        raise BadInputError(f"parameter file {path}: cannot be read: {error}") from error
    except yaml.YAMLError as error:
        raise BadInputError(f"parameter file {path}: is not YAML: {error}") from error
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


def unused_files(arguments: Sequence[str], node: str) -> list[str]:
    """Return a line for each parameter file on a command line that holds nothing for a node.

    Parameters
    ----------
    arguments : sequence of str
        Command line of the node's process, ROS arguments included.
    node : str
        Fully qualified name of the node.

    Raises
    ------
    BadInputError
        If a file cannot be read or is not YAML.
    """
    lines = []
    for path in _parameter_files(arguments):
        found = sections(path)
        if any(is_for(section, node) for section in found):
            continue
        has = f"its sections are {', '.join(found)}" if found else "it has no sections"
        lines.append(
            f"parameter file {path}: holds nothing for {node}, {has}; "
            f"a section /**/{node.rpartition('/')[2]} is for this node in any namespace"
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
