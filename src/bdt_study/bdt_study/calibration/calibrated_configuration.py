"""The machine that was found as a ROS parameter file for all nodes."""

from collections.abc import Mapping
from typing import Any

import yaml

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_files import PARAMETERS_KEY
from bdt_msgs_py.parameter_tables import in_parameter_names, known_parameters, parameter_sets
from bdt_msgs_py.topics import CONTROLLER_NODE, PLANT_NODE, TWIN_NODE
from bdt_study.calibration.constant import GAP, Constant
from bdt_study.calibration.start_values import TABLES, Configuration
from bdt_twin.dead_zone_tolerance import tolerance_for_gap

COVERAGE = 2.0
"""Standard uncertainties that the controller's first dead zone adds to the gap."""
STATIC_FRICTION = "motor.static_friction"
"""What a machine has not in which it was not found, whatever the start values say."""
DIGITS = 9
"""Digits of a value."""

HEADER = """\
# The machine that `bdt calibrate` found in {source}.
# Values of start that the data did not tell: {held}.
"""


def calibrated_configuration(
    configuration: Configuration | None,
    start: Mapping[str, float],
    constants: Mapping[str, Constant],
) -> Configuration:
    """Return the parameters of all nodes with the machine that was found.

    The plant simulates it, the twin believes in it, and the controller begins with the dead zone
    for its gap and takes the amplifier's offset back. Everything else is as before, also the gap
    and the dead zone if the data do not tell the gap.

    Parameters
    ----------
    configuration : Configuration or None
        The file with the start values.
    start : mapping of str
        Constants of the mechanism with which the calibration began.
    constants : mapping of str
        What was found; names that are no parameter of a node are left out.

    Raises
    ------
    BadInputError
        If values that were found do not go together with the others.
    """
    before = configuration or {}
    values = {node: dict(before.get(node, {})) for node in {**TABLES, **before}}
    for node in (CONTROLLER_NODE, TWIN_NODE):
        values[node].setdefault("use_sim_time", True)
    found = {name: each.value for name, each in constants.items()}
    if not constants[GAP].determined:
        del found[GAP]
    found["sensor.delay"] = max(found["sensor.delay"], 0.0)
    for node in (PLANT_NODE, TWIN_NODE):
        known = known_parameters(TABLES[node])
        values[node] |= {name: value for name, value in start.items() if name in known}
        values[node] |= {name: value for name, value in found.items() if name in known}
    if STATIC_FRICTION not in found:
        values[PLANT_NODE].pop(STATIC_FRICTION, None)
    if GAP in found:
        values[PLANT_NODE]["gap.kind"] = "constant"
        gap = constants[GAP]
        bound = gap.value + COVERAGE * gap.standard_uncertainty
        values[CONTROLLER_NODE]["dead_zone_tolerance"] = tolerance_for_gap(
            bound, start["lead_screw.pitch"]
        )
    if constants["actuator.offset"].determined:
        values[CONTROLLER_NODE]["voltage_offset"] = -found["actuator.offset"]
    # The paper's estimator needs signals without noise.
    values[TWIN_NODE].setdefault("estimator.kind", "output_error")
    for node, table in TABLES.items():
        values[node] = {name: _rounded(value) for name, value in values[node].items()}
        try:
            parameter_sets(table, values[node])
        except ValueError as error:
            raise BadInputError(
                f"the machine that was found goes not with the other values of {node}: "
                f"{in_parameter_names(str(error), table)}"
            ) from error
    return values


def configuration_text(
    configuration: Configuration, source: str, constants: Mapping[str, Constant]
) -> str:
    """Return a configuration as the text of a ROS parameter file.

    Parameters
    ----------
    configuration : Configuration
        Parameters of the nodes.
    source : str
        Where it comes from, for the header.
    constants : mapping of str
        What was found, for the header.
    """
    held = ", ".join(name for name, each in constants.items() if not each.determined)
    document = {
        f"/**/{node}": {PARAMETERS_KEY: nested(values)} for node, values in configuration.items()
    }
    body = yaml.safe_dump(document, sort_keys=False, default_flow_style=None)
    return HEADER.format(source=" ".join(source.split()), held=held or "none") + body


def _rounded(value: Any) -> Any:
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values with dots in their names as mappings within mappings."""
    tree: dict[str, Any] = {}
    for name, value in values.items():
        *parents, last = name.split(".")
        place = tree
        for parent in parents:
            place = place.setdefault(parent, {})
        place[last] = value
    return tree
