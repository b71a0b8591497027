"""Forward model of a window: the plant's own step functions from voltage to position, compiled.

Beside the position, the loop notes what the sensitivities need. The screw only moves in contact,
so at any time its angle is that of the motor at the last contact, less or plus half of the gap at
that time: between contacts nothing depends on the gap.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.friction import frictional_motor_step
from bdt_plant.motor import MotorState, motor_step
from bdt_plant.plant import DiscretePlant, PlantState
from bdt_plant.structure import StructureState
from bdt_twin.applied_voltage import PROMPT
from bdt_twin.friction_change import UNCHANGED, FrictionChange
from bdt_twin.resisted_plant import ResistedPlant
from bdt_twin.window_loop import DRIVES, compiled_window

FloatArray = NDArray[np.float64]

SMALLEST_TRAVEL = float(np.deg2rad(1.0))
"""Angle by which the screw turns back before that counts as a reversal [rad]."""

MOST_REVERSALS = 1000
"""Reversals noted in a window; of more, the newest are."""


SLOW_VOLTAGE = 0.5
"""Voltage for which the motor turns slowly [V]: friction that depends on speed is felt there."""

STANDING_SHARE = 0.3
"""Share of the friction's voltage with which a motor that stands still may yet turn."""


class StretchResponse(NamedTuple):
    """What a simulation of one stretch of data gives.

    Attributes
    ----------
    position : ndarray, shape (n,)
        Position q3 [m].
    screw : ndarray, shape (blocks,)
        Mean angle of the lead screw over each block of samples [rad].
    side : ndarray, shape (blocks,)
        Mean direction of the last motion of the screw: 1 forward, -1 backward, 0 before any.
    motor : ndarray, shape (blocks,)
        Mean angle of the motor at the last contact [rad].
    sample : ndarray, shape (blocks,)
        Mean index of the sample of the last contact.
    relative_angle : ndarray, shape (n,)
        Angle of the motor less that of the screw [rad].
    motor_angle : ndarray, shape (n,)
        Angle of the motor [rad].
    reversals : list of int
        Samples at which the screw began to move the other way.
    travel : float
        Angle over which the screw moved [rad].
    drives : ndarray, shape (drives, blocks)
        Mean of time integrals over the motion of the motor up to the last contact: by how much
        a voltage [s] against the motion and one forward, a relative change of the gain beyond the
        motor's own angle [rad], an excess of friction at rest as a voltage [s], a relative change
        of the Stribeck speed per that excess [s], a load as a voltage per force [N s], the parts
        of cogging [s], friction that changes with time [s^2] and along the screw [m s], its
        yield angle per friction [s/rad], and the time constant of the amplifier [V] turn the
        motor, per what a motor turns in a second for a volt.
    fast, slow : ndarray, shape (blocks,)
        Time in each block for which the motor turns fast, and slowly or nearly so [s].
    contact : ndarray, shape (blocks,)
        One where the screw moves, else zero.
    """

    position: FloatArray
    screw: FloatArray
    side: FloatArray
    motor: FloatArray
    sample: FloatArray
    relative_angle: FloatArray
    motor_angle: FloatArray
    reversals: list[int]
    travel: float
    drives: FloatArray
    fast: FloatArray
    slow: FloatArray
    contact: FloatArray


class SlowMotion(NamedTuple):
    """When friction that depends on speed is felt.

    Attributes
    ----------
    speed : float
        Speed below which the motor turns slowly [rad/s].
    standing_voltage : float
        Voltage from which on a motor that stands still may yet turn [V].
    back_emf : float
        Back-EMF constant k_B [V s/rad].
    """

    speed: float
    standing_voltage: float
    back_emf: float


def slow_motion(friction: float, back_emf: float) -> SlowMotion:
    """Return when friction that depends on speed is felt.

    Parameters
    ----------
    friction : float
        Voltage of the friction [V].
    back_emf : float
        Back-EMF constant k_B [V s/rad].
    """
    return SlowMotion(SLOW_VOLTAGE / back_emf, STANDING_SHARE * friction, back_emf)


def simulate_stretch(
    step: ResistedPlant,
    state: PlantState,
    voltage: FloatArray,
    gaps: FloatArray,
    block: int,
    sample_time: float,
    motion: SlowMotion,
    change: FrictionChange = UNCHANGED,
    per_lag: FloatArray = PROMPT,
) -> StretchResponse:
    """Simulate the plant over one stretch of data (eqs 1, 2, 3 and 6).

    Parameters
    ----------
    step : ResistedPlant
        Discrete model of the plant.
    state : PlantState
        State at the first sample.
    voltage : ndarray, shape (n,)
        Motor voltage u [V], each held until the next sample; n is a multiple of `block`.
    gaps : ndarray, shape (n,)
        Backlash gap theta_b at the samples [rad], not negative.
    block : int
        Samples in a block.
    sample_time : float
        Sample time [s].
    motion : SlowMotion
        When the motor turns slowly.
    change : FrictionChange, optional
        How friction changes in the stretch.
    per_lag : ndarray, shape (n,), optional
        By how much the voltage changes with the time constant of the amplifier [V/s]; empty if
        that is not asked for.
    """
    count = voltage.size // block
    position, relative_angle, motor_angle = np.empty((3, voltage.size))
    blocks = np.zeros((7 + len(DRIVES), count))
    reversals = np.zeros(MOST_REVERSALS, dtype=np.int64)
    found, travel = compiled_window()(
        step,
        state,
        change,
        voltage,
        gaps,
        block,
        sample_time,
        motion.speed,
        motion.standing_voltage,
        motion.back_emf,
        SMALLEST_TRAVEL,
        position,
        relative_angle,
        motor_angle,
        blocks,
        reversals,
        _first_bend(step, float(voltage[0])),
        per_lag,
    )
    screw, side, motor, sample, fast, slow, contact = blocks[:7]
    order = range(max(found - MOST_REVERSALS, 0), found)
    noted = [int(reversals[n % MOST_REVERSALS]) for n in order]
    return StretchResponse(
        position,
        screw,
        side,
        motor,
        sample,
        relative_angle,
        motor_angle,
        noted,
        travel,
        blocks[7:],
        fast,
        slow,
        contact,
    )


def _first_bend(step: ResistedPlant, voltage: float) -> float:
    """Return the bend of friction that holds a motor with a voltage [V]."""
    taken = step.friction.coulomb * step.motor.resistance
    return min(max(voltage / taken, -1.0), 1.0) if taken > 0.0 else 0.0


def initial_state(
    structure: StructureState,
    relative_angle: float,
    voltages: FloatArray,
    back_emf: float,
    step: DiscretePlant,
) -> PlantState:
    """Return the state of a plant whose screw is at the angle zero.

    Parameters
    ----------
    structure : StructureState
        State of the structure.
    relative_angle : float
        Angle of the motor less that of the screw [rad].
    voltages : ndarray, shape (m,)
        Voltages up to the first one of a stretch, that included [V]. At the first of these the
        motor runs at the speed for it; it settles within milliseconds.
    back_emf : float
        Back-EMF constant k_B [V s/rad].
    step : DiscretePlant
        Discrete model of the plant.
    """
    *before, last = voltages.tolist()
    friction = step.friction
    driving = _driving(before[0] if before else last, friction.current * friction.resistance)
    motor = MotorState(0.0, driving / back_emf, 0.0)
    for voltage in before:
        if friction.current > 0.0:
            motor = frictional_motor_step(motor, voltage, step.motor, friction).motor
        else:
            motor = motor_step(motor, voltage, step.motor)
    return PlantState(motor._replace(angle=relative_angle), 0.0, 0, structure)


def _driving(voltage: float, friction: float) -> float:
    """Return what of a voltage [V] is left beside the friction's."""
    return math.copysign(max(abs(voltage) - friction, 0.0), voltage)


def travel_in(position: FloatArray, samples: float) -> FloatArray:
    """Return how far a position moves at the velocity of each sample in the time of some samples.

    Parameters
    ----------
    position : ndarray, shape (n,)
        Position [m].
    samples : float
        Time in sample times.
    """
    # What numpy.gradient gives, which takes more than twice as long.
    travel = np.empty(position.size)
    np.subtract(position[2:], position[:-2], out=travel[1:-1])
    travel[1:-1] *= 0.5 * samples
    travel[0] = samples * (position[1] - position[0])
    travel[-1] = samples * (position[-1] - position[-2])
    return travel
