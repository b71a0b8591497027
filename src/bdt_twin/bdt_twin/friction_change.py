"""Friction that changes while a window lasts: with time, as it warms up, and along the screw."""

import math
from typing import NamedTuple

TURNING = 1e-4
"""Speed of the motor from which on it turns [rad/s]."""


class FrictionChange(NamedTuple):
    """How the voltage that friction takes differs from what it is in the end, at position zero.

    Attributes
    ----------
    voltage : float
        What it is there [V].
    growth : float
        Its change with time, as a share [1/s].
    slope : float
        Its change along the screw, as a share [1/m].
    time : float
        Time of the first sample [s], from the newest one of the window on; not positive.
    place : float
        Position of the screw's end at the first sample [m].
    """

    voltage: float
    growth: float
    slope: float
    time: float
    place: float


UNCHANGED = FrictionChange(0.0, 0.0, 0.0, 0.0, 0.0)
"""Friction that stays what it is."""


def changed_share(time: float, place: float, change: FrictionChange) -> float:
    """Return the share by which friction differs from what it is in the end, at position zero.

    Parameters
    ----------
    time : float
        Time [s], from the newest sample of the window on; not positive.
    place : float
        Position of the screw's end [m].
    change : FrictionChange
        How friction changes.

    Returns
    -------
    float
        The share, -1 at least: no friction is less than none.
    """
    return max(change.growth * time + change.slope * place, -1.0)


def felt_voltage(
    voltage: float, speed: float, time: float, place: float, change: FrictionChange
) -> float:
    """Return the voltage with which a motor turns the same under friction that does not change.

    Parameters
    ----------
    voltage : float
        Motor voltage u [V].
    speed : float
        Speed of the motor [rad/s]; one that stands is about to turn as the voltage has it.
    time, place : float
        Time since the first sample [s], and travel of the screw since then [m].
    change : FrictionChange
        How friction changes.
    """
    more = changed_share(change.time + time, change.place + place, change) * change.voltage
    if abs(speed) > TURNING:
        return voltage - math.copysign(1.0, speed) * more
    # Friction holds a motor that stands, and never turns it.
    return voltage - math.copysign(1.0, voltage) * min(more, abs(voltage))
