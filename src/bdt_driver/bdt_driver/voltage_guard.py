"""What becomes of a commanded voltage: limited, no faster than allowed, engaged without a jump."""

import math

from bdt_driver.driver_settings import DriveLimits


class VoltageGuard:
    """Turns commanded voltages into those that the motor may get.

    After a rest commands come into force gradually: each is weighted with the time since the first
    one over the engage time. A controller that was not obeyed for a while may ask for anything;
    its integral then unwinds while it gains its hold.

    Parameters
    ----------
    limits : DriveLimits
        Largest voltage and its fastest change.
    engage_time : float
        Time from rest to full weight [s].

    Attributes
    ----------
    applied : float
        The voltage in force [V].
    limited : int
        Number of commands that were beyond a limit.
    """

    def __init__(self, limits: DriveLimits, engage_time: float) -> None:
        self._limits = limits
        self._engage_time = engage_time
        self._engaged_for = 0.0
        self.applied = 0.0
        self.limited = 0

    def rest(self) -> None:
        """Take the voltage away; what comes next engages anew."""
        self.applied = self._engaged_for = 0.0

    def voltage(self, commanded: float, period: float) -> float:
        """Return the voltage that the motor gets [V].

        Parameters
        ----------
        commanded : float
            Commanded voltage [V].
        period : float
            Time since the command before [s].
        """
        self._engaged_for += period
        weight = min(self._engaged_for / self._engage_time, 1.0)
        allowed = math.copysign(min(abs(commanded), self._limits.voltage), commanded)
        wanted = weight * allowed
        change = self._limits.voltage_rate * period
        following = min(max(wanted, self.applied - change), self.applied + change)
        self.limited += allowed != commanded or following != wanted
        self.applied = following
        return following
