"""Configurations: ordinary ROS parameter files, checked before any process is started.

A node started with ``ros2 run`` checks its own parameters; here all nodes of a file are checked at
once, with the file's name in the message and no process to clean up.
"""

from collections.abc import Iterable
from dataclasses import dataclass, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from bdt_controller.parameters import PARAMETERS as CONTROLLER_PARAMETERS
from bdt_msgs_py.quantities import Quantity, check, quantities_of
from bdt_msgs_py.topics import CONTROLLER_NODE, PLANT_NODE, TWIN_NODE
from bdt_plant.parameters import PARAMETERS as PLANT_PARAMETERS
from bdt_twin.parameters import PARAMETERS as TWIN_PARAMETERS

NODES: dict[str, tuple[tuple[str, type[Any]], ...]] = {
    PLANT_NODE: PLANT_PARAMETERS,
    CONTROLLER_NODE: CONTROLLER_PARAMETERS,
    TWIN_NODE: TWIN_PARAMETERS,
}
"""The nodes that ``bdt run`` starts, with their parameter dataclasses."""

_ROS_PARAMETERS = {"use_sim_time": False, "start_type_description_service": True}


class BadInputError(ValueError):
    """Something that a user gave is missing or not allowed; the text is one line."""

    def __init__(self, text: str) -> None:
        super().__init__(" ".join(text.split()))


@dataclass(frozen=True)
class Configuration:
    """A parameter file that was checked.

    Attributes
    ----------
    path : Path or None
        The file; None for the defaults alone.
    values : dict
        For each node the values by flat parameter name, as far as the file sets them.
    """

    path: Path | None
    values: dict[str, dict[str, Any]]

    @property
    def name(self) -> str:
        """Short name for output folders and titles."""
        return self.path.stem if self.path else "default"

    def value(self, node: str, parameter: str) -> Any:
        """Return a value in force: the file's, else the default."""
        if parameter in self.values[node]:
            return self.values[node][parameter]
        return known_parameters(node)[parameter][0]


def known_parameters(node: str) -> dict[str, tuple[Any, Quantity]]:
    """Return default and quantity of every parameter of a node by flat name."""
    return {
        f"{prefix}.{name}" if prefix else name: (default, described)
        for prefix, kind in NODES[node]
        for name, default, described in quantities_of(kind)
    }


def load_configuration(path: Path | None) -> Configuration:
    """Read and check a ROS parameter file.

    Parameters
    ----------
    path : Path or None
        The file; None for the defaults.

    Raises
    ------
    BadInputError
        With one line that names the file, the key, the value and what is allowed.
    """
    values: dict[str, dict[str, Any]] = {node: {} for node in NODES}
    if path is None:
        return Configuration(None, values)
    for section, parameters in _sections(path).items():
        for node in _nodes_of(section, path):
            known = known_parameters(node)
            for name, value in _flat(parameters):
                if name in known:
                    check_value(f"{path}: {section}: {name}", value, *known[name])
                elif name not in _ROS_PARAMETERS and not name.startswith("qos_overrides."):
                    if section.endswith("*"):
                        continue
                    raise BadInputError(
                        f"{path}: {section}: {name} = {value!r}: is not a parameter of this node"
                        f"{suggestion(name, known)}"
                    )
                values[node][name] = value
    configuration = Configuration(path, values)
    for node in NODES:
        try:
            parameter_sets(configuration, node)
        except ValueError as error:
            raise BadInputError(f"{path}: {node}: {error}") from error
    return configuration


def check_value(label: str, value: Any, default: Any, described: Quantity) -> None:
    """Check one value as strictly as the node would.

    Parameters
    ----------
    label : str
        What the message calls it.
    value, default, described
        See :func:`bdt_msgs_py.quantities.check`.

    Raises
    ------
    BadInputError
        With one line that names the parameter, the value and what is allowed.
    """
    # ROS parameters are typed: a node would refuse the integer 5 where 5.0 is wanted.
    items = value if isinstance(value, list) else [value]
    first = default[0] if isinstance(default, tuple) else default
    if isinstance(first, float) and any(type(item) is int for item in items):
        raise BadInputError(f"{label} = {value!r}: must be written with a decimal point")
    try:
        check(label, value, default, described)
    except ValueError as error:
        raise BadInputError(str(error)) from error


def parameter_sets(configuration: Configuration, node: str) -> list[Any]:
    """Return the dataclasses of a node with the values in force, in the order of its table.

    Parameters
    ----------
    configuration : Configuration
        The values, each of which was checked.
    node : str
        The node.

    Raises
    ------
    ValueError
        If values do not go together, with one line that says which.
    """
    built = []
    for prefix, kind in NODES[node]:
        lead = f"{prefix}." if prefix else ""
        values = {
            item.name: configuration.value(node, f"{lead}{item.name}") for item in fields(kind)
        }
        lists = {name: tuple(value) for name, value in values.items() if isinstance(value, list)}
        built.append(kind(**{**values, **lists}))
    return built


def suggestion(name: str, known: Iterable[str]) -> str:
    """Return the end of a message about an unknown name: the name that was meant, if any."""
    close = get_close_matches(name, known, n=1)
    return f"; did you mean {close[0]}?" if close else ""


def _sections(path: Path) -> dict[str, dict[str, Any]]:
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise BadInputError(f"configuration {path}: cannot be read: {_reason(error)}") from error
    except yaml.YAMLError as error:
        raise BadInputError(f"configuration {path}: is not YAML: {_reason(error)}") from error
    if not isinstance(document, dict) or not document:
        raise BadInputError(f"configuration {path}: must be a ROS parameter file with nodes")
    sections = {}
    for section, content in document.items():
        if not isinstance(content, dict) or set(content) != {"ros__parameters"}:
            raise BadInputError(f"{path}: {section}: must hold the key ros__parameters, only")
        sections[str(section)] = content["ros__parameters"] or {}
    return sections


def _reason(error: Exception) -> str:
    text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return " ".join(text.split())


def _nodes_of(section: str, path: Path) -> list[str]:
    name = section.rsplit("/", 1)[-1]
    if name in NODES:
        return [name]
    if name in ("*", "**"):
        return list(NODES)
    raise BadInputError(f"{path}: {section}: is not a node, must be one of {', '.join(NODES)}")


def _flat(parameters: Any, prefix: str = "") -> list[tuple[str, Any]]:
    if not isinstance(parameters, dict):
        return [(prefix, parameters)]
    lead = f"{prefix}." if prefix else ""
    return [item for name, value in parameters.items() for item in _flat(value, f"{lead}{name}")]
