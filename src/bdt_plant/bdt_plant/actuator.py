"""Actuator: the amplifier in front of the motor, whose voltage is limited."""

import math
from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate


@dataclass(frozen=True)
class ActuatorParameters:
    """Saturation of the motor's amplifier; the paper has none."""

    saturation: bool = quantity(False, "", "limit the motor voltage to voltage_limit")
    voltage_limit: float = quantity(
        48.0,
        "V",
        "largest motor voltage of either sign, with saturation",
        minimum=1e-3,
        maximum=1e6,
    )

    def __post_init__(self) -> None:
        validate(self)

    @property
    def limit(self) -> float:
        """Largest voltage of either sign [V]; infinite without saturation."""
        return float(self.voltage_limit) if self.saturation else math.inf


IDEAL_ACTUATOR = ActuatorParameters()
"""The paper's actuator: every voltage is applied as commanded."""


def saturated(voltage: float, limit: float) -> float:
    """Return the voltage that the amplifier applies [V].

    Parameters
    ----------
    voltage : float
        Commanded voltage [V].
    limit : float
        Largest voltage of either sign [V]; infinite for none.
    """
    return min(max(voltage, -limit), limit)
