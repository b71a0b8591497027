"""Values with which a calibration begins: a parameter file, what the bag tells, or the defaults."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from bdt_controller.parameters import PARAMETERS as CONTROLLER_PARAMETERS
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_files import PARAMETERS_KEY
from bdt_msgs_py.parameter_tables import (
    ParameterTable,
    check_value,
    full_name,
    in_parameter_names,
    known_parameters,
    parameter_sets,
    suggestion,
)
from bdt_msgs_py.topics import CONTROLLER_NODE, PLANT_NODE, TWIN_NODE
from bdt_plant.lead_screw import LeadScrewParameters
from bdt_plant.motor import MotorParameters
from bdt_plant.parameters import PARAMETERS as PLANT_PARAMETERS
from bdt_plant.plant import PlantModel
from bdt_plant.structure import StructureParameters
from bdt_twin.parameters import PARAMETERS as TWIN_PARAMETERS

Configuration = dict[str, dict[str, Any]]
"""For each node its values by flat parameter name."""

TABLES: dict[str, ParameterTable] = {
    PLANT_NODE: PLANT_PARAMETERS,
    CONTROLLER_NODE: CONTROLLER_PARAMETERS,
    TWIN_NODE: TWIN_PARAMETERS,
}
"""Parameters of the nodes that a calibration writes."""

MODEL: ParameterTable = (
    ("motor", MotorParameters),
    ("lead_screw", LeadScrewParameters),
    ("structure", StructureParameters),
)
"""Parameters of the mechanism, which plant and twin have in common."""

_ROS_PARAMETERS = ("use_sim_time", "start_type_description_service")


def read_configuration(path: Path) -> Configuration:
    """Read a ROS parameter file.

    Parameters
    ----------
    path : Path
        The file. Namespaces of its sections do not matter, sections of other nodes are left out.

    Raises
    ------
    BadInputError
        If it cannot be read, or a value is not allowed.
    """
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise BadInputError(f"--config {path}: cannot be read: {error}") from error
    except yaml.YAMLError as error:
        raise BadInputError(f"--config {path}: is not YAML: {error}") from error
    values: Configuration = {node: {} for node in TABLES}
    if not isinstance(document, dict) or not any(
        isinstance(content, dict) and PARAMETERS_KEY in content for content in document.values()
    ):
        raise BadInputError(f"--config {path}: must be a ROS parameter file with nodes")
    for section, content in document.items():
        parameters = content.get(PARAMETERS_KEY) if isinstance(content, dict) else None
        for node in TABLES:
            label = f"--config {path}: {section}"
            values[node] |= _checked(label, str(section), node, dict(_flat(parameters or {})))
    return values


def start_model(configuration: Configuration | None, recorded: Mapping[str, Any]) -> PlantModel:
    """Return the mechanism as it is believed to be.

    Parameters
    ----------
    configuration : Configuration or None
        Of a file; a value of the twin comes before one of the plant.
    recorded : mapping of str
        Parameters of the twin that the bag tells; they count if there is no file.

    Raises
    ------
    BadInputError
        If values do not go together or are not allowed.
    """
    values: dict[str, Any] = dict(recorded)
    if configuration is not None:
        values = configuration[PLANT_NODE] | configuration[TWIN_NODE]
    known = known_parameters(MODEL)
    values = {name: value for name, value in values.items() if name in known}
    for name, value in values.items():
        check_value(f"start value {name}", value, *known[name])
    try:
        return PlantModel(*parameter_sets(MODEL, values))
    except ValueError as error:
        raise BadInputError(in_parameter_names(str(error), MODEL)) from error


def model_values(model: PlantModel) -> dict[str, float]:
    """Return the constants of a mechanism by the names that they have as parameters."""
    parts = (model.motor, model.lead_screw, model.structure)
    return {
        full_name(prefix, name): float(getattr(part, name))
        for (prefix, kind), part in zip(MODEL, parts, strict=True)
        for name in vars(kind())
    }


def _checked(label: str, section: str, node: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return what a section of a file sets for a node."""
    named, known = section.rsplit("/", 1)[-1], known_parameters(TABLES[node])
    if named not in (node, "*", "**"):
        return {}
    values = {}
    for name, value in parameters.items():
        if name in known:
            check_value(f"{label}: {name}", value, *known[name])
        elif name not in _ROS_PARAMETERS and not name.startswith("qos_overrides."):
            # What is for all nodes need not be for this one.
            if named != node:
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
