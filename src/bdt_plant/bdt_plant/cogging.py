"""Cogging: the torque of a motor's magnets and teeth, a function of its angle alone."""

from dataclasses import dataclass
from typing import NamedTuple

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.elementary_functions import FULL_TURN, sine_of_turns
from bdt_plant.motor import MotorParameters


@dataclass(frozen=True)
class CoggingParameters:
    """Cogging of the motor; the paper has none."""

    cogging_torque: float = quantity(
        0.0, "N m", "amplitude of the cogging torque", minimum=0.0, maximum=1e3
    )
    cogging_periods: int = quantity(
        24, "", "periods of the cogging torque in one turn", minimum=1, maximum=10_000
    )

    def __post_init__(self) -> None:
        validate(self)


class Cogging(NamedTuple):
    """Cogging as a current against the motion.

    Attributes
    ----------
    current : float
        Current whose torque equals the amplitude [A]; 0 for none.
    periods_per_radian : float
        Periods in one radian.
    """

    current: float
    periods_per_radian: float


def cogging_of(motor: MotorParameters, cogging: CoggingParameters) -> Cogging:
    """Return the cogging of a motor."""
    return Cogging(
        cogging.cogging_torque / motor.torque_constant, cogging.cogging_periods / FULL_TURN
    )


def cogging_current(angle: float, cogging: Cogging) -> float:
    """Return the current whose torque equals the cogging's at an angle [rad], against it [A].

    The motor is drawn to the angle 0 and to each that is a whole number of periods from it.
    """
    if cogging.current == 0.0:
        return 0.0
    return cogging.current * sine_of_turns(angle * cogging.periods_per_radian)
