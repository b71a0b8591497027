"""An amplifier that follows its command late: a lag of first order in front of the motor.

Its rounding, gain and offset come before (:mod:`bdt_plant.actuator`). Over a step the motor gets
the mean of the exact solution.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

from bdt_msgs_py.quantities import quantity, validate


@dataclass(frozen=True)
class AmplifierLag:
    """How late the motor's amplifier is; the paper's is prompt."""

    lag: float = quantity(
        0.0,
        "s",
        "time constant with which the voltage follows its command",
        minimum=0.0,
        maximum=1.0,
    )

    def __post_init__(self) -> None:
        validate(self)


class DiscreteLag(NamedTuple):
    """A lag over one step.

    Attributes
    ----------
    kept : float
        Share of the distance from the command that is left at the end of a step.
    mean : float
        Share of it that there is in the mean over the step.
    """

    kept: float
    mean: float


def discretize_lag(amplifier: AmplifierLag, step_time: float) -> DiscreteLag:
    """Return the lag for steps of a time [s]."""
    lag = float(amplifier.lag)
    if lag == 0.0:
        return DiscreteLag(0.0, 0.0)
    gone = -math.expm1(-step_time / lag)
    return DiscreteLag(1.0 - gone, gone * lag / step_time)
