"""Lead screw (eq. 1) with backlash (eq. 6)."""

import math
from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.elementary_functions import FULL_TURN, sine_of_turns


@dataclass(frozen=True)
class LeadScrewParameters:
    """Geometry of the lead screw (table 1)."""

    pitch: float = quantity(
        1e-3 / (2 * math.pi), "m/rad", "pitch p: travel per radian", minimum=1e-9, maximum=1e3
    )

    def __post_init__(self) -> None:
        validate(self)


def screw_end(theta_d: float, pitch: float, thread_error: float) -> float:
    """Return the position d of the lead screw's end, whose thread may be off (eq. 1) [m].

    Parameters
    ----------
    theta_d : float
        Angle of the lead screw [rad].
    pitch : float
        Pitch p [m/rad].
    thread_error : float
        Amplitude of an error that repeats with each turn [m]; 0 for none.
    """
    if thread_error == 0.0:
        return pitch * theta_d
    return pitch * theta_d + thread_error * sine_of_turns(theta_d / FULL_TURN)


def play(theta_d: float, theta_m: float, gap: float) -> float:
    """Return the angle of the lead screw after the motor moved to `theta_m` (eq. 6).

    Over one sample in which the motor turns monotonically, integrating eq. 6 exactly gives the
    play operator: the screw stays where it is as long as it is within half a gap of the motor.

    Parameters
    ----------
    theta_d : float
        Angle of the lead screw before [rad].
    theta_m : float
        Angle of the motor now [rad].
    gap : float
        Backlash gap theta_b now [rad], not negative.
    """
    half = 0.5 * gap
    return min(max(theta_d, theta_m - half), theta_m + half)


def contact_side(theta_d: float, theta_m: float, gap: float) -> int:
    """Return on which side of the gap the motor touches the screw.

    Parameters
    ----------
    theta_d : float
        Angle of the lead screw, from :func:`play` [rad].
    theta_m : float
        Angle of the motor [rad].
    gap : float
        Backlash gap theta_b [rad].

    Returns
    -------
    int
        1 if the motor is at the end of the gap from which it drives the screw forward (the one
        case without a gap), -1 at the other end, 0 between them.
    """
    half = 0.5 * gap
    if theta_d == theta_m - half:
        return 1
    if theta_d == theta_m + half:
        return -1
    return 0
