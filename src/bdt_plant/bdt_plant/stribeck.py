"""Friction of the motor that depends on speed (Stribeck) and on the direction.

The torque against a motion at the speed w is

    tau(w) = (tau_C + (tau_s - tau_C) exp(-(w / w_s)^2)) (1 + a sgn w)

with Coulomb's friction tau_C, the one at rest tau_s, the Stribeck speed w_s and the asymmetry a. At
rest friction is whatever holds the motor, up to tau_s in either direction, see
:mod:`bdt_plant.resisted_motor`. Viscous friction is linear and part of the motor.
"""

from dataclasses import dataclass
from typing import NamedTuple

from bdt_msgs_py.quantities import quantity, validate
from bdt_plant.elementary_functions import decaying_exponential
from bdt_plant.motor import MotorParameters


@dataclass(frozen=True)
class StribeckParameters:
    """What a motor's friction has beyond Coulomb's; the paper has none."""

    static_friction: float = quantity(
        0.0,
        "N m",
        "largest friction torque of a standing motor; coulomb_friction when it is smaller",
        minimum=0.0,
        maximum=1e3,
    )
    stribeck_speed: float = quantity(
        2.0,
        "rad/s",
        "speed at which 63 % of what static_friction is more than coulomb_friction are gone",
        minimum=1e-6,
        maximum=1e6,
    )
    friction_asymmetry: float = quantity(
        0.0,
        "",
        "share by which friction is larger forward and smaller backward",
        minimum=-1.0,
        maximum=1.0,
    )

    def __post_init__(self) -> None:
        validate(self)


class FrictionLaw(NamedTuple):
    """Friction of a motor, as currents whose torques equal it.

    Attributes
    ----------
    coulomb : float
        Friction of a fast motor [A].
    excess : float
        How much more it is at rest [A].
    stribeck_speed : float
        Stribeck speed [rad/s].
    forward, backward : float
        Factors of the directions.
    """

    coulomb: float
    excess: float
    stribeck_speed: float
    forward: float
    backward: float


def friction_law(motor: MotorParameters, stribeck: StribeckParameters) -> FrictionLaw:
    """Return the friction of a motor."""
    coulomb = motor.coulomb_friction / motor.torque_constant
    excess = max(stribeck.static_friction - motor.coulomb_friction, 0.0) / motor.torque_constant
    asymmetry = stribeck.friction_asymmetry
    speed = float(stribeck.stribeck_speed)
    return FrictionLaw(coulomb, excess, speed, 1.0 + asymmetry, 1.0 - asymmetry)


def friction_size(speed: float, law: FrictionLaw) -> float:
    """Return the friction at a speed [rad/s], without the factor of the direction [A]."""
    if law.excess == 0.0:
        return law.coulomb
    ratio = speed / law.stribeck_speed
    return law.coulomb + law.excess * decaying_exponential(-ratio * ratio)
