"""Configurations: ordinary ROS parameter files, checked before any process is started.

A node started with ``ros2 run`` checks its own parameters; here all nodes of a file are checked at
once, with the file's name in the message and no process to clean up.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bdt_bringup.installed import parameter_table
from bdt_bringup.loop_state import MACHINES
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_files import (
    PARAMETERS_KEY,
    checked_parameters,
    is_for,
    read_sections,
)
from bdt_msgs_py.parameter_tables import known_parameters, parameter_sets
from bdt_msgs_py.topics import CONTROLLER_NODE, DRIVER_NODE, PLANT_NODE, TWIN_NODE

CONFIGURED_NODES = (PLANT_NODE, CONTROLLER_NODE, TWIN_NODE)
"""Nodes whose parameters a configuration sets; the recorder's are options of ``bdt run``.

In a configuration of a real machine the driver stands in place of the plant.
"""

FREE_PREFIXES = {DRIVER_NODE: "drive."}
"""Beginning of the names of parameters that only somebody's own code knows, by node."""


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
    machine : str
        The machine of the loop: ``driver`` where the file has a section for it, else ``plant``.
    """

    path: Path | None
    values: dict[str, dict[str, Any]]
    configured: frozenset[str] = frozenset()
    namespace: str = ""
    machine: str = PLANT_NODE

    @property
    def name(self) -> str:
        """Short name for output folders and titles."""
        return self.path.stem if self.path else "default"

    def value(self, node: str, parameter: str) -> Any:
        """Return a value in force: the file's, else the default."""
        if parameter in self.values[node]:
            return self.values[node][parameter]
        return known_parameters(parameter_table(node))[parameter][0]


def load_configuration(
    path: Path | None, namespace: str = "", machine: str | None = None
) -> Configuration:
    """Read and check a ROS parameter file.

    Parameters
    ----------
    path : Path or None
        The file; None for the defaults.
    namespace : str
        Namespace of the nodes, for example ``/left``; sections for nodes elsewhere are checked,
        but their values are not used.
    machine : str, optional
        ``plant`` or ``driver``, which a file that has sections for both needs; the section of the
        other one is left out.

    Raises
    ------
    BadInputError
        With one line that names the file, the key, the value and what is allowed.
    """
    if path is None:
        if machine == DRIVER_NODE:
            raise BadInputError("--machine driver: needs a --config with the driver's parameters")
        return Configuration(None, {node: {} for node in CONFIGURED_NODES}, namespace=namespace)
    sections = _sections(path)
    machine = machine or _machine_of(sections, path)
    left_out = set(MACHINES) - {machine}
    sections = {name: given for name, given in sections.items() if _last(name) not in left_out}
    nodes = _nodes_with(machine)
    values: dict[str, dict[str, Any]] = {node: {} for node in nodes}
    configured = _configured(sections, namespace, path, nodes)
    for section, parameters in sections.items():
        for node in _nodes_of(section, path, nodes):
            used = values[node] if is_for(section, f"{namespace}/{node}") else {}
            used |= checked_parameters(
                f"{path}: {section}",
                parameters,
                parameter_table(node),
                for_all=section.endswith("*"),
                free_prefix=FREE_PREFIXES.get(node),
            )
    configuration = Configuration(path, values, configured, namespace, machine)
    for node in nodes:
        try:
            parameter_sets(parameter_table(node), configuration.values[node])
        except ValueError as error:
            raise BadInputError(f"{path}: {node}: {error}") from error
    return configuration


def _machine_of(sections: Iterable[str], path: Path) -> str:
    """Return the machine that a file is about."""
    named = [node for node in MACHINES if any(_last(section) == node for section in sections)]
    if len(named) > 1:
        raise BadInputError(
            f"{path}: has {' and '.join(named)}: a loop has one of them, choose it with --machine"
        )
    return named[0] if named else PLANT_NODE


def _nodes_with(machine: str) -> tuple[str, ...]:
    return tuple(machine if node == PLANT_NODE else node for node in CONFIGURED_NODES)


def _configured(
    sections: Iterable[str], namespace: str, path: Path, nodes: Sequence[str]
) -> frozenset[str]:
    """Return the nodes for which there is a section; refuse sections for others of their names."""
    found = set()
    for node in nodes:
        full_name = f"{namespace}/{node}"
        named = [section for section in sections if node in _nodes_of(section, path, nodes)]
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


def _nodes_of(section: str, path: Path, nodes: Sequence[str]) -> list[str]:
    name = _last(section)
    if name in nodes:
        return [name]
    if name in ("*", "**"):
        return list(nodes)
    raise BadInputError(
        f"{path}: {section}: is not a node, must be one of "
        f"{', '.join((*CONFIGURED_NODES, DRIVER_NODE))}"
    )


def _last(section: str) -> str:
    """Return the last part of a section's name: a node, or a pattern."""
    return section.rsplit("/", 1)[-1]
