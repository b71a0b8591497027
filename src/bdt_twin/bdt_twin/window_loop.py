"""The loops over the samples of a window, compiled with the plant's own step functions."""

from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import compile_with_steps
from bdt_plant.plant import (
    AT_REST,
    DiscretePlant,
    PlantModel,
    PlantState,
    discretize_plant,
    plant_step,
)
from bdt_plant.structure import DiscreteStructure, StructureState, structure_step

FloatArray = NDArray[np.float64]

SMALLEST_SPEED = 1e-4
"""Speed of the motor from which on it turns [rad/s]."""


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


def _window_loop(sources: str) -> Any:  # noqa: PLR0915 - one loop, compiled as a whole
    def window_loop(  # noqa: PLR0912, PLR0915
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
