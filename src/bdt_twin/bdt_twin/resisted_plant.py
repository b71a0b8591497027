"""The plant of the paper with a motor that friction holds back by its speed, and a load by force.

What the paper leaves out acts on the motor only: its friction is larger at rest (Stribeck), and the
structure resists the screw. Both are torques that are held over a sample, from the plant's own
functions. A long sample in which the motor stops, turns or breaks loose is taken in parts: there
friction is not what is held.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import decaying_exponential
from bdt_plant.lead_screw import contact_side, play
from bdt_plant.motor import MotorState
from bdt_plant.plant import DiscretePlant, PlantState
from bdt_plant.resisted_motor import ResistedMotor, resisted_motor_step
from bdt_plant.screw_load import ScrewLoad, backward_load, forward_load
from bdt_plant.stribeck import FrictionLaw
from bdt_plant.structure import structure_step
from bdt_twin.cog_wave import cog_wave
from bdt_twin.yielding_friction import yielding_motor_step

FloatArray = NDArray[np.float64]

FAST = 4.0
"""Multiples of the Stribeck speed from which on friction is that of a fast motor."""
COGGED_SPEED = 20.0
"""Speed from which on cogging is not felt [rad/s]: it changes its sign many times in a second."""
STEEPEST = 0.8
"""Largest share of the back-EMF's slope that falling friction takes away, as far as slopes go."""
SHARES_PER_SPEED = 128
"""Values of the share of friction at rest that are known for each Stribeck speed."""
SHARES = np.array(
    [
        decaying_exponential(-((number / SHARES_PER_SPEED) ** 2))
        for number in range(round(FAST * SHARES_PER_SPEED) + 1)
    ]
)
"""Stribeck's curve; the line between two values is off by 2e-5."""


class Cogs(NamedTuple):
    """Cogging, a wave of the motor's angle, as currents against forward motion.

    Attributes
    ----------
    periods_per_radian : float
        Periods in one radian; 0 for none.
    sine, cosine : float
        Parts of the wave [A].
    """

    periods_per_radian: float
    sine: float
    cosine: float


NO_COGS = Cogs(0.0, 0.0, 0.0)
"""No cogging."""


class ResistedPlant(NamedTuple):
    """Discrete model of the plant with a resisted motor.

    Attributes
    ----------
    plant : DiscretePlant
        The plant, with Coulomb friction.
    motor : ResistedMotor
        The motor alone.
    friction : FrictionLaw
        Its friction.
    load : ScrewLoad
        What it feels of the structure.
    stiffness, damping : float
        Those of the structure's lowest beams [N/m, N s/m].
    cogs : Cogs
        Cogging of the motor.
    yield_angle : float
        Yield angle of friction that yields before it slides [rad]; 0 for a rigid one.
    sample_time : float
        Sample time [s].
    parts : int
        Parts in which a sample is taken where the motor stops, turns or breaks loose.
    in_part : ResistedMotor
        The motor alone over one of these.
    """

    plant: DiscretePlant
    motor: ResistedMotor
    friction: FrictionLaw
    load: ScrewLoad
    stiffness: float
    damping: float
    cogs: Cogs
    yield_angle: float
    sample_time: float
    parts: int
    in_part: ResistedMotor


def resisted_plant_step(
    state: PlantState, voltage: float, gap: float, step: ResistedPlant, bend: float
) -> PlantState:
    """Advance the plant by one sample (eqs 1, 2, 3 and 6, and what resists the motor).

    In contact the screw moves evenly within a sample, which is within nanometers of
    :func:`bdt_plant.plant.plant_step`.

    Parameters
    ----------
    state : PlantState
        State at the beginning of the sample.
    voltage : float
        Motor voltage u [V], held over the sample.
    gap : float
        Backlash gap theta_b [rad] at the end of the sample.
    step : ResistedPlant
        Discrete model of the plant.
    bend : float
        Bend of friction that yields, at the beginning.
    """
    driven = driven_screw(state, voltage, gap, step, step.motor, step.sample_time, bend)
    if step.parts > 1 and turns(state.motor, driven.motor):
        driven, part = state, step.sample_time / step.parts
        for _ in range(step.parts):
            driven = driven_screw(driven, voltage, gap, step, step.in_part, part, bend)
    pitch = step.plant.pitch
    structure = structure_step(
        state.structure, pitch * state.theta_d, pitch * driven.theta_d, step.plant.structure
    )
    return PlantState(driven.motor, driven.theta_d, driven.contact, structure)


def turns(before: MotorState, after: MotorState) -> bool:
    """Tell whether a motor stops, turns back or breaks loose in between."""
    return before.speed * after.speed <= 0.0 and before.speed != after.speed


def driven_screw(
    state: PlantState,
    voltage: float,
    gap: float,
    step: ResistedPlant,
    resisted: ResistedMotor,
    step_time: float,
    bend: float,
) -> PlantState:
    """Advance motor and screw by a step, while the structure waits.

    Parameters
    ----------
    state : PlantState
        State at the beginning of the step.
    voltage : float
        Motor voltage u [V], held over the step.
    gap : float
        Backlash gap theta_b [rad].
    step : ResistedPlant
        Discrete model of the plant.
    resisted : ResistedMotor
        The motor alone over the step.
    step_time : float
        Time that the step takes [s].
    bend : float
        Bend of friction that yields, at the beginning.
    """
    law, speed = step.friction, state.motor.speed
    is_slow = law.excess > 0.0 and abs(speed) < FAST * law.stribeck_speed
    is_loaded = step.load.against > 0.0 and state.contact != 0
    forward = backward = 0.0
    if is_loaded:
        force = screw_force(state, step)
        forward = forward_load(force, state.contact, gap, step.load)
        backward = backward_load(force, state.contact, gap, step.load)
    load = 0.0
    if step.cogs.periods_per_radian > 0.0 and abs(speed) < COGGED_SPEED:
        middle_angle = state.motor.angle + 0.5 * step_time * speed
        sine, cosine = cog_wave(middle_angle * step.cogs.periods_per_radian)
        load = step.cogs.sine * sine + step.cogs.cosine * cosine
    middle, motor = speed, state.motor
    # A second time with the friction of the speed in the middle of the sample.
    for _ in range(2 if is_slow else 1):
        size = law.coulomb
        if is_slow:
            size += law.excess * slow_share(abs(middle) / law.stribeck_speed)
        if step.yield_angle > 0.0:
            loads = load, backward, forward
            motor = yielding_motor_step(
                state.motor, voltage, loads, size, bend, step.yield_angle, resisted
            )
        else:
            motor = resisted_motor_step(
                state.motor, voltage, load, backward + size, forward + size, resisted
            )
        if speed * motor.speed <= 0.0:
            break
        middle = 0.5 * (speed + motor.speed)
    theta_d = play(state.theta_d, motor.angle, gap)
    contact = contact_side(theta_d, motor.angle, gap)
    return PlantState(motor, theta_d, contact, state.structure)


def screw_force(state: PlantState, step: ResistedPlant) -> float:
    """Return the force with which the structure resists the screw, positive backward [N]."""
    pitch, structure = step.plant.pitch, state.structure
    velocity = pitch * state.motor.speed if state.contact != 0 else 0.0
    return step.stiffness * (pitch * state.theta_d - structure.q2) + step.damping * (
        velocity - structure.q2_velocity
    )


def slow_share(ratio: float) -> float:
    """Return which share of the excess of friction at rest is there at a speed.

    This is the curve of :func:`bdt_plant.stribeck.friction_size`, from a table: it is asked for
    several times in each sample.

    Parameters
    ----------
    ratio : float
        The speed over the Stribeck speed, not negative.
    """
    place = ratio * SHARES_PER_SPEED
    number = int(place)
    if number >= SHARES.size - 1:
        return 0.0
    below = float(SHARES[number])
    return below + (place - number) * (float(SHARES[number + 1]) - below)


def steepness(excess: float, stribeck_speed: float, back_emf: float) -> float:
    """Return how steeply friction falls with speed, for :func:`slope_left`.

    Parameters
    ----------
    excess : float
        Voltage that friction takes at rest beside what it takes at speed [V].
    stribeck_speed : float
        Speed at which 1/e of it is left [rad/s].
    back_emf : float
        The motor's back-EMF constant [V s/rad].
    """
    return 2.0 * excess / (stribeck_speed * back_emf)


def slope_left(ratio: float, share: float, steep: float) -> float:
    """Return which share of the back-EMF's slope is left where friction falls with speed.

    A motor whose friction is less when it is faster turns faster by a voltage than one whose
    friction is constant; the voltage is felt as if it were larger by this.

    Parameters
    ----------
    ratio : float
        The speed over the Stribeck speed, not negative.
    share : float
        What :func:`slow_share` returns for it.
    steep : float
        What :func:`steepness` returns.
    """
    return 1.0 - min(steep * ratio * share, STEEPEST)
