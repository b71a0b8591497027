"""Values with which a calibration begins: a parameter file, what the bag tells, or the defaults."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bdt_controller.parameters import PARAMETERS as CONTROLLER_PARAMETERS
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_files import (
    PARAMETERS_KEY,
    checked_parameters,
    no_parameter_file,
    read_sections,
)
from bdt_msgs_py.parameter_tables import (
    ParameterTable,
    check_value,
    full_name,
    in_parameter_names,
    known_parameters,
    parameter_sets,
)
from bdt_msgs_py.topics import CONTROLLER_NODE, DRIVER_NODE, PLANT_NODE, TWIN_NODE
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


def read_configuration(path: Path) -> Configuration:
    """Read a ROS parameter file.

    Parameters
    ----------
    path : Path
        The file. Namespaces of its sections do not matter. The driver's section is taken as it
        is, sections of other nodes are left out.

    Raises
    ------
    BadInputError
        If it cannot be read, or a value is not allowed.
    """
    label = f"--config {path}"
    sections = {
        section: content[PARAMETERS_KEY] or {}
        for section, content in read_sections(label, path).items()
        if isinstance(content, dict) and PARAMETERS_KEY in content
    }
    if not sections:
        raise no_parameter_file(label)
    values: Configuration = {node: {} for node in TABLES}
    for section, parameters in sections.items():
        named = section.rsplit("/", 1)[-1]
        for_all = named in ("*", "**")
        for node, table in TABLES.items():
            if for_all or named == node:
                values[node] |= checked_parameters(
                    f"{label}: {section}", parameters, table, for_all=for_all
                )
        if named == DRIVER_NODE:
            # A robot has its table, and the class of the drive names parameters of its own.
            values[DRIVER_NODE] = checked_parameters(
                f"{label}: {section}", parameters, (), for_all=False, free_prefix=""
            )
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
