"""A constant after a calibration, and those that keep the value with which it began."""

from collections.abc import Mapping
from dataclasses import dataclass

VISCOUS_SHARE = 0.005
"""Share of the back EMF that viscous friction which nobody has looked for may seem to be."""

GAP = "gap.initial"
"""The gap by the name that it has as a parameter."""
HELD = (
    "motor.torque_constant",
    "motor.resistance",
    "motor.inertia",
    "motor.inductance",
    "motor.viscous_friction",
    "structure.mass",
)
"""Constants that voltage and position cannot tell."""

_BY_OTHER_MEANS = {
    "motor.torque_constant": "a measured current, or a known torque",
    "motor.resistance": "voltage and current of the motor at rest",
    "motor.inertia": "a known torque, or the data sheet of the motor",
    "motor.inductance": "voltage and current of the motor at rest",
    "motor.viscous_friction": "a measured current at two speeds",
    "structure.mass": "a pair of scales",
}


@dataclass(frozen=True)
class Constant:
    """A constant of the machine after a calibration.

    Attributes
    ----------
    value : float
        Its value.
    unit : str
        Unit of the value.
    standard_uncertainty : float
        Standard uncertainty, the doubt about what it is stated for included.
    determined : bool
        Whether the data tell it; otherwise it has its start value.
    given : tuple of str
        Constants that the data do not tell, for whose start values it is stated.
    standard_uncertainty_given : float
        Standard uncertainty if these were known exactly.
    revealed_by : str
        What would tell a constant that is not determined; "" for one that is.
    """

    value: float
    unit: str
    standard_uncertainty: float
    determined: bool
    given: tuple[str, ...] = ()
    standard_uncertainty_given: float = 0.0
    revealed_by: str = ""


def held_constants(values: Mapping[str, float], doubt: Mapping[str, float]) -> dict[str, Constant]:
    """Return the constants that keep their start values.

    Parameters
    ----------
    values : mapping of str
        Constants of the mechanism by name.
    doubt : mapping of str
        Relative standard uncertainty of each of ``HELD``.
    """
    units = {
        "motor.torque_constant": "N m/A",
        "motor.resistance": "Ohm",
        "motor.inertia": "kg m^2",
        "motor.inductance": "H",
        "motor.viscous_friction": "N m s/rad",
        "structure.mass": "kg",
    }
    held = {}
    for name in HELD:
        spread = values[name] * doubt[name]
        if name == "motor.viscous_friction" and doubt[name]:
            back_emf = values["motor.back_emf_constant"] * values["motor.torque_constant"]
            spread = max(spread, VISCOUS_SHARE * back_emf / values["motor.resistance"])
        held[name] = Constant(
            values[name],
            units[name],
            spread,
            determined=False,
            standard_uncertainty_given=spread,
            revealed_by=_BY_OTHER_MEANS[name],
        )
    return held
