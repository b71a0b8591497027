"""What the motor feels of the structure through the lead screw, and the screw's elasticity.

Let F be the force with which the structure resists the screw, positive when it pushes it backward.
To drive the screw against it takes the torque p F / eta; a screw that follows it gives p F eta.
Here eta is the efficiency of the thread; one below one half is self-locking: no force drives it.
Between the two torques the thread holds the load. So the load is part of the set-valued friction
(:mod:`bdt_plant.resisted_motor`): what it takes to go on in either direction.

With a gap the motor touches the screw on one side; it can only push, and backs off without a load.
As in eq. 6 the screw stays where the motor leaves it: its thread is taken to hold it.
"""

from dataclasses import dataclass
from typing import NamedTuple

from bdt_msgs_py.quantities import quantity, validate

SELF_LOCKING = 0.5
"""Efficiency below which a thread cannot be driven by its load."""


@dataclass(frozen=True)
class ScrewMechanics:
    """What the paper's lead screw has not, which is rigid, even and acts one way."""

    efficiency: float = quantity(
        0.0,
        "",
        "work on the structure per work of the motor; 0: the motor does not feel the structure",
        minimum=0.0,
        maximum=1.0,
    )
    stiffness: float = quantity(
        0.0,
        "N/m",
        "stiffness k_d of the lead screw, platform 1 then having a mass; 0 for a rigid screw",
        minimum=0.0,
        maximum=1e10,
    )
    thread_error: float = quantity(
        0.0,
        "m",
        "amplitude of an error of the screw's travel that repeats with each turn",
        minimum=0.0,
        maximum=1e-2,
    )

    def __post_init__(self) -> None:
        validate(self)


class ScrewLoad(NamedTuple):
    """How a force on the screw becomes a load of the motor.

    Attributes
    ----------
    against, along : float
        Current per force for driving the screw against and along it [A/N]; both 0 when the motor
        does not feel the structure.
    """

    against: float
    along: float


def screw_load(mechanics: ScrewMechanics, pitch: float, torque_constant: float) -> ScrewLoad:
    """Return what a motor with a torque constant [N m/A] feels through a screw of a pitch [m/rad].

    Parameters
    ----------
    mechanics : ScrewMechanics
        The screw.
    pitch : float
        Pitch p [m/rad].
    torque_constant : float
        Torque constant k_T [N m/A].
    """
    efficiency = mechanics.efficiency
    if efficiency == 0.0:
        return ScrewLoad(0.0, 0.0)
    per_force = pitch / torque_constant
    along = per_force * efficiency if efficiency >= SELF_LOCKING else 0.0
    return ScrewLoad(per_force / efficiency, along)


def forward_load(force: float, contact: int, gap: float, load: ScrewLoad) -> float:
    """Return the load of a motor that goes on forward, as a current [A].

    Parameters
    ----------
    force : float
        Force of the structure on the screw, positive backward [N].
    contact : int
        Side of the gap on which the motor touches the screw; see
        :func:`bdt_plant.lead_screw.contact_side`.
    gap : float
        Backlash gap [rad].
    load : ScrewLoad
        From :func:`screw_load`.
    """
    if gap > 0.0 and (contact != 1 or force < 0.0):
        return 0.0
    return force * (load.against if force > 0.0 else load.along)


def backward_load(force: float, contact: int, gap: float, load: ScrewLoad) -> float:
    """Return the load of a motor that goes on backward, as a current [A]; see forward_load."""
    if gap > 0.0 and (contact != -1 or force > 0.0):
        return 0.0
    return -force * (load.against if force < 0.0 else load.along)
