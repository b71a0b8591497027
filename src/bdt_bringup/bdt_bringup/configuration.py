"""Configurations: ordinary ROS parameter files, checked before any process is started.

A node started with ``ros2 run`` checks its own parameters; here all nodes of a file are checked at
once, with the file's name in the message and no process to clean up.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bdt_bringup.installed import parameter_table
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_files import (
    PARAMETERS_KEY,
    checked_parameters,
    is_for,
    read_sections,
)
from bdt_msgs_py.parameter_tables import known_parameters, parameter_sets
from bdt_msgs_py.topics import CONTROLLER_NODE, PLANT_NODE, TWIN_NODE

CONFIGURED_NODES = (PLANT_NODE, CONTROLLER_NODE, TWIN_NODE)
"""Nodes whose parameters a configuration sets; the recorder's are options of ``bdt run``."""


@dataclass(frozen=True)
class Configuration:
    """A parameter file that was checked.

    Attributes
    ----------
    path : Path or None
        The file; None for the defaults alone.
    values : dict
        For each node the values by flat parameter name, as far as the file sets them.
    configured : frozenset of str
        Nodes for which the file has a section.
    namespace : str
        Namespace of the nodes, for example ``/left``; "" for that of the root.
    """

    path: Path | None
    values: dict[str, dict[str, Any]]
    configured: frozenset[str] = frozenset()
    namespace: str = ""

    @property
    def name(self) -> str:
        """Short name for output folders and titles."""
        return self.path.stem if self.path else "default"

    def value(self, node: str, parameter: str) -> Any:
        """Return a value in force: the file's, else the default."""
        if parameter in self.values[node]:
            return self.values[node][parameter]
        return known_parameters(parameter_table(node))[parameter][0]


def load_configuration(path: Path | None, namespace: str = "") -> Configuration:
    """Read and check a ROS parameter file.

    Parameters
    ----------
    path : Path or None
        The file; None for the defaults.
    namespace : str
        Namespace of the nodes, for example ``/left``; sections for nodes elsewhere are checked,
        but their values are not used.

    Raises
    ------
    BadInputError
        With one line that names the file, the key, the value and what is allowed.
    """
    values: dict[str, dict[str, Any]] = {node: {} for node in CONFIGURED_NODES}
    if path is None:
        return Configuration(None, values, namespace=namespace)
    sections = _sections(path)
    configured = _configured(sections, namespace, path)
    for section, parameters in sections.items():
        for node in _nodes_of(section, path):
            used = values[node] if is_for(section, f"{namespace}/{node}") else {}
            used |= checked_parameters(
                f"{path}: {section}",
                parameters,
                parameter_table(node),
                for_all=section.endswith("*"),
            )
    configuration = Configuration(path, values, configured, namespace)
    for node in CONFIGURED_NODES:
        try:
            parameter_sets(parameter_table(node), configuration.values[node])
        except ValueError as error:
            raise BadInputError(f"{path}: {node}: {error}") from error
    return configuration


def _configured(sections: Iterable[str], namespace: str, path: Path) -> frozenset[str]:
    """Return the nodes for which there is a section; refuse sections for others of their names."""
    found = set()
    for node in CONFIGURED_NODES:
        full_name = f"{namespace}/{node}"
        named = [section for section in sections if node in _nodes_of(section, path)]
        if any(is_for(section, full_name) for section in named):
            found.add(node)
        elif named:
            raise BadInputError(
                f"{path}: {', '.join(named)}: holds nothing for {full_name}; a section "
                f"/**/{node} is for this node in any namespace"
            )
    return frozenset(found)


def _sections(path: Path) -> dict[str, dict[str, Any]]:
    sections = {}
    for section, content in read_sections(f"configuration {path}", path).items():
        if not isinstance(content, dict) or set(content) != {PARAMETERS_KEY}:
            raise BadInputError(f"{path}: {section}: must hold the key {PARAMETERS_KEY}, only")
        sections[section] = content[PARAMETERS_KEY] or {}
    return sections


def _nodes_of(section: str, path: Path) -> list[str]:
    name = section.rsplit("/", 1)[-1]
    if name in CONFIGURED_NODES:
        return [name]
    if name in ("*", "**"):
        return list(CONFIGURED_NODES)
    raise BadInputError(
        f"{path}: {section}: is not a node, must be one of {', '.join(CONFIGURED_NODES)}"
    )
