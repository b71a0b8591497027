"""A lead-screw drive with everything that a real one has.

``running_machine`` moves it.
"""

import math
from dataclasses import dataclass

PITCH = 1e-3 / (2.0 * math.pi)
"""Travel of the screw per angle [m/rad]."""
LARGEST_VOLTAGE = 24.0
"""Limit of the voltage [V]."""
PER_RUN = 1.0 / 120.0
"""Makes a drift [m/s] of what it is over the paper's run [m]."""


@dataclass(frozen=True)
class UnknownMachine:
    """Constants of the mechanism; by default it is the paper's, with a good sensor.

    Torques are at the motor's shaft [N m], speeds in rad/s, everything else in SI units.
    """

    inertia: float = 5e-6
    inductance: float = 1e-3
    resistance: float = 12.0
    warming: float = 0.0
    """Share by which the resistance rises in each second."""
    torque_constant: float = 0.8
    back_emf_constant: float = 0.1
    viscous_friction: float = 0.0
    coulomb_friction: float = 0.0
    friction_at_rest: float = 0.0
    """Friction of a motor that stands; the smaller of both counts as none."""
    stribeck_speed: float = 2.0
    friction_asymmetry: float = 0.0
    """Share by which friction is larger forward, and smaller backward."""
    friction_along: float = 0.0
    """Share by which friction is larger for each meter of the screw's travel."""
    friction_in_turn: float = 0.0
    """Share by which friction is larger and smaller within each turn of the screw."""
    friction_fade: float = 0.0
    """Share of the friction that is lost in each second."""
    presliding: float = 0.0
    """Angle over which bristles bend before friction is Coulomb's [rad]; 0 for none."""
    bristle_damping: float = 0.1
    """Damping of the bristles over the root of their stiffness and the motor's inertia."""
    cogging: float = 0.0
    cogs: float = 24.0
    mass: float = 5.2
    stiffness: float = 1e4
    damping: float = 36.9
    upper_mass: float = 1.0
    """Mass of the top platform over that of the other."""
    upper_stiffness: float = 1.0
    """Stiffness of the upper beams over that of the lower ones."""
    cubic_stiffness: float = 0.0
    """Force of a beam per cube of its bend [N/m^3]."""
    efficiency: float = 0.0
    """Of a screw that is driven against the structure; 0 for one that the structure never loads."""
    screw_stiffness: float = 0.0
    """Of a screw that drives a mass, with the beams' load on the motor; 0 for a rigid one."""
    thread_error: float = 0.0
    """Amplitude of an error of the screw's travel that repeats with each turn."""
    gap_along: float = 0.0
    """Share by which the gap is larger for each meter of the screw's travel."""
    guide_friction: float = 0.0
    """Coulomb friction of each platform."""
    amplifier_gain: float = 1.0
    amplifier_offset: float = 0.0
    amplifier_bits: int = 0
    amplifier_dead_band: float = 0.0
    """Voltage that is missing in either direction, up to which nothing comes out."""
    amplifier_sag: float = 0.0
    """Share of the gain that is missing at the limit of the voltage."""
    bridge_drop: float = 0.0
    """Voltage that is lost in the direction of the current, whatever that is."""
    amplifier_lag: float = 0.0
    """Time constant with which the voltage follows its command."""
    noise: float = 1e-6
    quantum: float = 1e-7
    delay: float = 0.0
    bias: float = 0.0
    drift_rate: float = 0.0
    encoder_error: float = 0.0
    """Amplitude of an error of the reading that is periodic over 20 um."""
    push_force: float = 0.0
    """Force on a platform for 50 ms every 7 s, to and fro."""
    pushes_middle: bool = False
    """Whether the second platform is pushed, not the top one."""


EVERYDAY = UnknownMachine(
    resistance=12.0 * 1.08,
    back_emf_constant=0.1 * 1.04,
    viscous_friction=1e-5,
    coulomb_friction=8e-3,
    friction_at_rest=10e-3,
    cogging=1e-3,
    mass=5.2 * 1.02,
    stiffness=1e4 * 0.98,
    damping=36.9 * 1.1,
    efficiency=0.4,
    amplifier_offset=0.02,
    amplifier_bits=12,
    delay=2e-4,
    drift_rate=5e-6 * PER_RUN,
    encoder_error=0.2e-6,
)
"""A machine with a bit of everything."""
