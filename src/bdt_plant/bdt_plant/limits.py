"""Limits of the hardware, whatever is commanded: what a motor's driver sees to."""

import math
from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate


@dataclass(frozen=True)
class HardwareLimits:
    """Voltage that the motor may get, and travel that platform 3 has."""

    voltage: float = quantity(
        48.0,
        "V",
        "largest motor voltage of either sign; what is commanded beyond is limited",
        minimum=1e-3,
        maximum=1e6,
    )
    position: float = quantity(
        0.05,
        "m",
        "largest measured position of platform 3 of either sign; beyond it the voltage is 0 until "
        "the platform is back",
        minimum=1e-6,
        maximum=1e3,
    )

    def __post_init__(self) -> None:
        validate(self)


class LimitedDrive:
    """Keeps commanded voltages within the limits of the hardware.

    Beyond the travel the motor gets no voltage in either direction: whatever brought the platform
    there (a sensor, a sign, a controller) cannot be trusted to bring it back.

    Parameters
    ----------
    limits : HardwareLimits
        The limits.

    Attributes
    ----------
    limited_steps : int
        Number of control periods whose commanded voltage was beyond the limit.
    stopped_steps : int
        Number of control periods without voltage because of the position.
    is_stopped : bool
        Whether the position is beyond its limit.
    """

    def __init__(self, limits: HardwareLimits) -> None:
        self._limits = limits
        self.limited_steps = self.stopped_steps = 0
        self.is_stopped = False

    @property
    def stop_reason(self) -> str:
        """Why the motor gets no voltage while the drive is stopped."""
        return f"position beyond {self._limits.position:g} m: the motor gets 0 V"

    def voltage(self, commanded: float, position: float) -> float:
        """Return the voltage that the motor gets [V].

        Parameters
        ----------
        commanded : float
            Commanded voltage [V].
        position : float
            Measured position of platform 3 [m].
        """
        # False for a position that is not a number, too.
        self.is_stopped = not abs(position) <= self._limits.position
        if self.is_stopped or not math.isfinite(commanded):
            self.stopped_steps += 1
            return 0.0
        if abs(commanded) <= self._limits.voltage:
            return commanded
        self.limited_steps += 1
        return math.copysign(self._limits.voltage, commanded)
