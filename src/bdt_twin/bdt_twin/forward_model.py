"""Forward model of a window: the plant's own step functions from voltage to position, compiled.

Beside the position, the loop notes what the sensitivities need. The screw only moves in contact,
so at any time its angle is that of the motor at the last contact, less or plus half of the gap at
that time: between contacts nothing depends on the gap.
"""

from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import compile_with_steps
from bdt_plant.motor import MotorState
from bdt_plant.plant import (
    AT_REST,
    DiscretePlant,
    PlantModel,
    PlantState,
    discretize_plant,
    plant_step,
)
from bdt_plant.structure import (
    DiscreteStructure,
    StructureState,
    structure_step,
)

FloatArray = NDArray[np.float64]

SMALLEST_TRAVEL = float(np.deg2rad(1.0))
"""Angle by which the screw turns back before that counts as a reversal [rad]."""

SMALLEST_SPEED = 1e-4
"""Speed of the motor from which on it turns [rad/s]."""

MOST_REVERSALS = 1000
"""Reversals noted in a window; of more, the newest are."""


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
    reversals : list of int
        Samples at which the screw began to move the other way.
    travel : float
        Angle over which the screw moved [rad].
    turning, turned : ndarray, shape (blocks,)
        Mean time for which the motor had turned up to the last contact, and the same with forward
        less backward [s].
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
    reversals: list[int]
    travel: float
    turning: FloatArray
    turned: FloatArray
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
    """

    speed: float
    standing_voltage: float


def simulate_stretch(
    step: DiscretePlant,
    state: PlantState,
    voltage: FloatArray,
    gaps: FloatArray,
    block: int,
    sample_time: float,
    motion: SlowMotion,
) -> StretchResponse:
    """Simulate the plant over one stretch of data (eqs 1, 2, 3 and 6).

    Parameters
    ----------
    step : DiscretePlant
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
    """
    count = voltage.size // block
    position, relative_angle = np.empty(voltage.size), np.empty(voltage.size)
    blocks = np.zeros((9, count))
    reversals = np.zeros(MOST_REVERSALS, dtype=np.int64)
    found, travel = compiled_window()(
        step,
        state,
        voltage,
        gaps,
        block,
        sample_time,
        motion.speed,
        motion.standing_voltage,
        SMALLEST_TRAVEL,
        position,
        relative_angle,
        blocks,
        reversals,
    )
    screw, side, motor, sample, turning, turned, fast, slow, contact = blocks
    order = range(max(found - MOST_REVERSALS, 0), found)
    noted = [int(reversals[n % MOST_REVERSALS]) for n in order]
    return StretchResponse(
        position,
        screw,
        side,
        motor,
        sample,
        relative_angle,
        noted,
        travel,
        turning,
        turned,
        fast,
        slow,
        contact,
    )


def simulate_structure(
    step: DiscreteStructure, state: StructureState, base: FloatArray
) -> FloatArray:
    """Return position q3 of platform 3 for a base that moves as given (eq. 3).

    Parameters
    ----------
    step : DiscreteStructure
        Discrete model for the spacing of `base`.
    state : StructureState
        State at the first instant.
    base : ndarray, shape (n,)
        Position d of the lead screw's end [m].
    """
    position = np.empty(base.size)
    compiled_structure()(step, state, base, position)
    return position


def initial_state(
    structure: StructureState, relative_angle: float, voltage: float, back_emf: float
) -> Any:
    """Return the state of a plant whose screw is at the angle zero.

    Parameters
    ----------
    structure : StructureState
        State of the structure.
    relative_angle : float
        Angle of the motor less that of the screw [rad].
    voltage : float
        First voltage [V]: the motor settles within milliseconds, so it runs at the speed for it.
    back_emf : float
        Back-EMF constant k_B [V s/rad].
    """
    motor = MotorState(0.0, voltage / back_emf, relative_angle)
    return PlantState(motor, 0.0, 0, structure)


@cache
def compiled_window() -> Any:
    """Return the loop over the samples of a window, compiled."""

    def signature() -> Any:
        # Imported here, because it is absent on many a small computer.
        numba = import_module("numba")
        types, typeof = numba.types, numba.typeof
        given = types.Array(types.float64, 1, "C", readonly=True)
        signal = types.Array(types.float64, 1, "C")
        return (
            typeof(_model_step()),
            typeof(AT_REST),
            given,
            given,
            types.int64,
            *(types.float64 for _ in range(4)),
            signal,
            signal,
            types.Array(types.float64, 2, "C"),
            types.Array(types.int64, 1, "C"),
        )

    return compile_with_steps(_window_loop, [plant_step], signature)


@cache
def compiled_structure() -> Any:
    """Return the loop over the instants of :func:`simulate_structure`, compiled."""

    def signature() -> Any:
        # Imported here, because it is absent on many a small computer.
        numba = import_module("numba")
        types, typeof = numba.types, numba.typeof
        given = types.Array(types.float64, 1, "C", readonly=True)
        signal = types.Array(types.float64, 1, "C")
        return typeof(_model_step().structure), typeof(AT_REST.structure), given, signal

    return compile_with_steps(_structure_loop, [structure_step], signature)


def _model_step() -> DiscretePlant:
    return discretize_plant(PlantModel(), 2e-4)


def _window_loop(sources: str) -> Any:
    def window_loop(
        step: DiscretePlant,
        state: PlantState,
        voltage: FloatArray,
        gaps: FloatArray,
        block: int,
        sample_time: float,
        slow_speed: float,
        standing_voltage: float,
        smallest_travel: float,
        position: FloatArray,
        relative_angle: FloatArray,
        blocks: FloatArray,
        reversals: NDArray[np.int64],
    ) -> tuple[int, float]:
        _ = sources
        last_side, last_motor, last_sample = 0.0, state.motor.angle, 0.0
        turning, turned, last_turning, last_turned = 0.0, 0.0, 0.0, 0.0
        before = state.theta_d
        direction, extreme, turned_at, found, travel = 0.0, before, 0, 0, 0.0
        share, k = 1.0 / block, -1
        for number in range(voltage.size // block):
            angles, sides, motors, samples, turnings, turneds = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            fast, slow, contact = 0.0, 0.0, 0.0
            for _ in range(block):
                k += 1
                if k > 0:
                    state = plant_step(state, voltage[k - 1], gaps[k], step)
                speed = state.motor.speed
                if abs(speed) > slow_speed:
                    fast += sample_time
                elif abs(speed) > SMALLEST_SPEED or abs(voltage[k]) > standing_voltage:
                    slow += sample_time
                if speed > SMALLEST_SPEED:
                    turning += sample_time
                    turned += sample_time
                elif speed < -SMALLEST_SPEED:
                    turning += sample_time
                    turned -= sample_time
                angle = state.theta_d
                if angle != before:
                    last_side = 1.0 if angle > before else -1.0
                    last_motor, last_sample = state.motor.angle, float(k)
                    last_turning, last_turned = turning, turned
                    contact = 1.0
                    travel += abs(angle - before)
                    if direction * (angle - extreme) >= 0.0:
                        # Of a screw that has not moved yet any motion is the first direction.
                        if direction == 0.0:
                            direction = last_side
                        extreme = angle
                    else:
                        if before == extreme:
                            turned_at = k
                        if direction * (extreme - angle) >= smallest_travel:
                            reversals[found % reversals.size] = turned_at
                            found += 1
                            direction, extreme = -direction, angle
                    before = angle
                position[k] = state.structure.q3
                relative_angle[k] = state.motor.angle - angle
                angles += angle
                sides += last_side
                motors += last_motor
                samples += last_sample
                turnings += last_turning
                turneds += last_turned
            blocks[0, number], blocks[1, number] = share * angles, share * sides
            blocks[2, number], blocks[3, number] = share * motors, share * samples
            blocks[4, number], blocks[5, number] = share * turnings, share * turneds
            blocks[6, number], blocks[7, number], blocks[8, number] = fast, slow, contact
        return found, travel

    return window_loop


def _structure_loop(sources: str) -> Any:
    def structure_loop(
        step: DiscreteStructure, state: StructureState, base: FloatArray, position: FloatArray
    ) -> None:
        _ = sources
        for k in range(base.size):
            if k > 0:
                state = structure_step(state, base[k - 1], base[k], step)
            position[k] = state.q3

    return structure_loop
