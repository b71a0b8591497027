"""From what a node says of its parameters to the controls of a page."""

import math
import re
from dataclasses import dataclass
from typing import Any

from bdt_msgs_py.parameter_files import ROS_PARAMETERS

UNIT = re.compile(r"^(?P<text>.*?)(?: \[(?P<unit>[^\[\]]*)\])?$", re.DOTALL)

SPREAD = 1000.0
"""Times the value in force beyond which a parameter's own range is too wide to drag in."""

STEPS = 400
"""Steps of a slider that has none of its own."""

USEFUL_RANGES = {
    "dead_zone_tolerance": (0.0, 1e-4),
    "voltage_offset": (-1.0, 1.0),
    "reference.first": (-0.01, 0.01),
    "reference.second": (-0.01, 0.01),
    "reference.step_time": (0.5, 20.0),
    "gap.initial": (0.0, math.radians(30.0)),
    "gap.final": (0.0, math.radians(60.0)),
    "gap.growth_time": (1.0, 300.0),
    "sensor.noise": (0.0, 1e-5),
    "motor.coulomb_friction": (0.0, 0.05),
    "communication_delay": (0.0, 5.0),
}
"""Where sliders of this project's parameters begin and end; any value that a node takes can be
typed beside the slider."""


@dataclass(frozen=True)
class Description:
    """What a node says of a parameter: a ``ParameterDescriptor`` as plain values.

    Attributes
    ----------
    name, description, constraints : str
        As in the descriptor; a unit is in brackets at the end of the description.
    read_only : bool
        Whether it stays as it is.
    minimum, maximum, step : float or None
        Range, as far as it has one.
    """

    name: str
    description: str = ""
    constraints: str = ""
    read_only: bool = False
    minimum: float | None = None
    maximum: float | None = None
    step: float | None = None


def control_of(described: Description, value: Any) -> dict[str, Any]:
    """Return the control of a parameter, as the page gets it.

    Parameters
    ----------
    described : Description
        What the node says of it.
    value : bool, int, float, str or list
        The value in force.

    Returns
    -------
    dict
        ``name``, ``value``, ``kind`` (``switch``, ``slider``, ``choice``, ``text`` or ``fixed``),
        ``unit``, ``text``, ``allowed``; a slider has ``low``, ``high`` and ``step`` as well, and
        a choice ``choices``.
    """
    parts = UNIT.match(described.description)
    text, unit = (parts["text"], parts["unit"] or "") if parts else (described.description, "")
    control = {
        "name": described.name,
        "value": list(value) if isinstance(value, (list, tuple)) else value,
        "unit": unit,
        "text": text,
        "allowed": described.constraints,
    }
    # ROS calls its own parameters no read-only ones; a loop whose clock is taken away stands still.
    is_fixed = described.read_only or described.name in ROS_PARAMETERS
    if is_fixed or isinstance(control["value"], list):
        return {**control, "kind": "fixed"}
    if isinstance(value, bool):
        return {**control, "kind": "switch"}
    if isinstance(value, str):
        if described.constraints.startswith("one of "):
            choices = described.constraints.removeprefix("one of ").split(", ")
            return {**control, "kind": "choice", "choices": choices}
        return {**control, "kind": "text"}
    low, high = slider_range(described, float(value))
    step = described.step or ((high - low) / STEPS if isinstance(value, float) else 1)
    return {**control, "kind": "slider", "low": low, "high": high, "step": step}


def slider_range(described: Description, value: float) -> tuple[float, float]:
    """Return where the slider of a number begins and ends, within the range that the node takes.

    Parameters
    ----------
    described : Description
        What the node says of it.
    value : float
        The value in force, which is between the two.
    """
    least = -math.inf if described.minimum is None else described.minimum
    most = math.inf if described.maximum is None else described.maximum
    if described.name in USEFUL_RANGES:
        low, high = USEFUL_RANGES[described.name]
    elif value and (most - least) > SPREAD * abs(value):
        low, high = sorted((0.0, 2.0 * value))
    elif math.isfinite(most - least):
        low, high = least, most
    else:
        low, high = 0.0, 1.0
    return max(least, min(low, value)), min(most, max(high, value))
