"""Where the paper's loop is among the parameters of a study."""

import math

from bdt_msgs_py.parameter_tables import known_parameters
from bdt_plant.lead_screw import LeadScrewParameters
from bdt_study.simulation.configured_loop import TABLES
from bdt_twin.dead_zone_tolerance import tolerance_for_gap

MEAN_GAP = math.radians(10.0)
"""Mean of the growing gap, which the paper's constant estimate is [rad]."""

NOT_DEFAULT = {
    "plant.gap.initial": MEAN_GAP,
    "controller.dead_zone_tolerance": tolerance_for_gap(MEAN_GAP, LeadScrewParameters().pitch),
}
"""Parameters whose default is not what the paper's loop has on average."""


def paper_value(name: str) -> float | None:
    """Return the paper's value of a parameter by node and flat name; None for what is no number."""
    if name in NOT_DEFAULT:
        return NOT_DEFAULT[name]
    node, _, flat = name.partition(".")
    default, _ = known_parameters(TABLES[node])[flat]
    is_number = isinstance(default, int | float) and not isinstance(default, bool)
    return float(default) if is_number else None
