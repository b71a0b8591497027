"""Actuator: the amplifier in front of the motor, which is limited and not quite right.

A command is limited to what the amplifier can give; that is the voltage which telemetry states. The
motor gets it rounded, times a gain, with an offset, within the limit: nobody knows of that.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bdt_msgs_py.quantities import quantity, validate


@dataclass(frozen=True)
class ActuatorParameters:
    """Imperfections of the motor's amplifier; the paper has none."""

    saturation: bool = quantity(False, "", "limit the motor voltage to voltage_limit")
    voltage_limit: float = quantity(
        48.0,
        "V",
        "largest motor voltage of either sign, with saturation",
        minimum=1e-3,
        maximum=1e6,
    )
    offset: float = quantity(
        0.0, "V", "voltage that the amplifier adds to every command", minimum=-1e3, maximum=1e3
    )
    gain: float = quantity(
        1.0, "", "voltage of the motor per voltage commanded", minimum=1e-3, maximum=1e3
    )
    resolution: float = quantity(
        0.0, "V", "step between two voltages; 0 for none", minimum=0.0, maximum=1e3
    )

    def __post_init__(self) -> None:
        validate(self)

    @property
    def limit(self) -> float:
        """Largest voltage of either sign [V]; infinite without saturation."""
        return float(self.voltage_limit) if self.saturation else math.inf


IDEAL_ACTUATOR = ActuatorParameters()
"""The paper's actuator: every voltage is applied as commanded."""


class Amplifier(NamedTuple):
    """Numbers of an amplifier, as the loop uses them.

    Attributes
    ----------
    limit : float
        Largest voltage of either sign [V]; infinite for none.
    is_exact : bool
        Whether the motor gets what is commanded within the limit.
    offset : float
        Voltage that is added [V].
    gain : float
        Voltage per voltage commanded.
    resolution : float
        Step between two voltages [V]; 0 for none.
    """

    limit: float
    is_exact: bool
    offset: float
    gain: float
    resolution: float


def amplifier_of(parameters: ActuatorParameters) -> Amplifier:
    """Return the numbers of an amplifier."""
    is_exact = not parameters.offset and not parameters.resolution and parameters.gain == 1.0
    return Amplifier(
        parameters.limit,
        is_exact,
        float(parameters.offset),
        float(parameters.gain),
        float(parameters.resolution),
    )


def saturated(voltage: float, limit: float) -> float:
    """Return the command as far as the amplifier can follow it [V].

    Parameters
    ----------
    voltage : float
        Commanded voltage [V].
    limit : float
        Largest voltage of either sign [V]; infinite for none.
    """
    return min(max(voltage, -limit), limit)


def amplified(command: float, amplifier: Amplifier) -> float:
    """Return the voltage that the motor gets [V].

    Parameters
    ----------
    command : float
        Command within the limit, from :func:`saturated` [V].
    amplifier : Amplifier
        From :func:`amplifier_of`.
    """
    if amplifier.is_exact:
        return command
    if amplifier.resolution > 0.0:
        command = float(np.rint(command / amplifier.resolution)) * amplifier.resolution
    return saturated(amplifier.gain * command + amplifier.offset, amplifier.limit)
