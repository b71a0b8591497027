"""The loops over the samples of a window, compiled with the plant's own step functions."""

from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import compile_with_steps
from bdt_plant.plant import AT_REST, PlantModel, PlantState, discretize_plant, plant_step
from bdt_plant.resisted_motor import discretize_resisted_motor
from bdt_plant.screw_load import ScrewLoad
from bdt_plant.stribeck import friction_law
from bdt_twin.cog_wave import cog_wave
from bdt_twin.friction_change import (
    TURNING,
    UNCHANGED,
    FrictionChange,
    changed_share,
    felt_voltage,
)
from bdt_twin.resisted_plant import (
    COGGED_SPEED,
    FAST,
    NO_COGS,
    ResistedPlant,
    driven_screw,
    resisted_plant_step,
    screw_force,
    slope_left,
    slow_share,
    steepness,
    turns,
)
from bdt_twin.yielding_friction import bend_after, held_bend, way_left, yielding_motor_step

FloatArray = NDArray[np.float64]

DRIVES = (
    "friction",
    "offset",
    "gain",
    "excess",
    "stribeck_speed",
    "load",
    "cogging_sine",
    "cogging_cosine",
    "growth",
    "slope",
    "yielding",
    "lag",
)
"""What moves the motor, as time integrals since the beginning; see ``StretchResponse.drives``."""
DRIVE_COUNT = len(DRIVES)


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
            typeof(UNCHANGED),
            given,
            given,
            types.int64,
            *(types.float64 for _ in range(5)),
            signal,
            signal,
            signal,
            types.Array(types.float64, 2, "C"),
            types.Array(types.int64, 1, "C"),
            types.float64,
            signal,
        )

    return compile_with_steps(_window_loop, STEPS, signature)


STEPS = (
    plant_step,
    resisted_plant_step,
    driven_screw,
    turns,
    screw_force,
    slow_share,
    steepness,
    slope_left,
    cog_wave,
    way_left,
    bend_after,
    held_bend,
    yielding_motor_step,
    changed_share,
    felt_voltage,
)
"""Step functions that the loop over a window calls."""


def _model_step() -> ResistedPlant:
    model, sample_time = PlantModel(), 2e-4
    motor = discretize_resisted_motor(model.motor, sample_time)
    return ResistedPlant(
        discretize_plant(model, sample_time),
        motor,
        friction_law(model.motor, model.stribeck),
        ScrewLoad(0.0, 0.0),
        0.0,
        0.0,
        NO_COGS,
        0.0,
        sample_time,
        1,
        motor,
    )


def _window_loop(sources: str) -> Any:  # noqa: PLR0915 - one loop, compiled as a whole
    def window_loop(  # noqa: PLR0912, PLR0915
        step: ResistedPlant,
        state: PlantState,
        change: FrictionChange,
        voltage: FloatArray,
        gaps: FloatArray,
        block: int,
        sample_time: float,
        slow_speed: float,
        standing_voltage: float,
        back_emf: float,
        smallest_travel: float,
        position: FloatArray,
        relative_angle: FloatArray,
        motor_angle: FloatArray,
        blocks: FloatArray,
        reversals: NDArray[np.int64],
        bend: float,
        per_lag: FloatArray,
    ) -> tuple[int, float]:
        _ = sources
        last_side, last_motor, last_sample = 0.0, state.motor.angle, 0.0
        drives, last_drives = np.zeros(DRIVE_COUNT), np.zeros(DRIVE_COUNT)
        begun = np.zeros(DRIVE_COUNT)
        law, cogs = step.friction, step.cogs.periods_per_radian
        taken, yield_angle = law.coulomb * step.motor.resistance, step.yield_angle
        yields = taken > 0.0 and yield_angle > 0.0
        # By how much the drives have bent friction that yields, which holds that against them, and
        # the drives before a sample.
        bent_by, driven = np.zeros(DRIVE_COUNT), np.zeros(DRIVE_COUNT)
        per_turn = 1.0 / (yield_angle * back_emf) if yields else 0.0
        per_yielding = 1.0 / (yield_angle * yield_angle * taken) if yields else 0.0
        is_resisted = (
            step.parts > 1 or yields or law.excess > 0.0 or step.load.against > 0.0 or cogs > 0.0
        )
        lags = per_lag.size > 0
        changes, pitch = change.growth != 0.0 or change.slope != 0.0, step.plant.pitch
        per_speed = 1.0 / law.stribeck_speed
        steep = steepness(law.excess * step.motor.resistance, law.stribeck_speed, back_emf)
        before = state.theta_d
        direction, extreme, turned_at, found, travel = 0.0, before, 0, 0, 0.0
        part, k = 1.0 / block, -1
        for number in range(voltage.size // block):
            angles, sides, motors, samples = 0.0, 0.0, 0.0, 0.0
            fast, slow, contact = 0.0, 0.0, 0.0
            begun[:] = last_drives
            for _ in range(block):
                k += 1
                turned_from = state.motor.angle
                time, place = k * sample_time, pitch * before
                if k > 0:
                    applied = voltage[k - 1]
                    if changes:
                        applied = felt_voltage(applied, state.motor.speed, time, place, change)
                    if is_resisted:
                        state = resisted_plant_step(state, applied, gaps[k], step, bend)
                    else:
                        state = plant_step(state, applied, gaps[k], step.plant)
                speed = state.motor.speed
                if abs(speed) > slow_speed:
                    fast += sample_time
                elif abs(speed) > TURNING or abs(voltage[k]) > standing_voltage:
                    slow += sample_time
                turned = state.motor.angle - turned_from
                if yields and (abs(bend) < 1.0 or turned * bend < 0.0):
                    left = way_left(turned, yield_angle)
                    bend = bend_after(bend, turned, left)
                    if abs(bend) == 1.0:
                        bent_by[:] = 0.0
                    else:
                        bent_by *= left
                        bent_by[10] += (turned - bend * abs(turned)) * per_yielding
                if abs(speed) > TURNING:
                    # A voltage is felt more where friction falls with speed.
                    ahead = 1.0 if speed > 0.0 else -1.0
                    sign, felt, amplified = ahead, sample_time, 0.0
                    holds, size = yields and abs(bend) < 1.0, taken
                    if holds:
                        sign = bend
                        driven[:] = drives
                    ratio = abs(speed) * per_speed
                    if ratio < FAST:
                        share = slow_share(ratio)
                        size += law.excess * step.motor.resistance * share
                        felt = sample_time / slope_left(ratio, share, ahead * sign * steep)
                        amplified = felt - sample_time
                        drives[3] += sign * felt * share
                        drives[4] += sign * felt * share * 2.0 * ratio * ratio
                    lasted, covered = change.time + time, change.place + place
                    drives[0] += sign * felt * (1.0 + changed_share(lasted, covered, change))
                    drives[1] += felt
                    drives[2] += amplified * speed
                    if state.contact != 0:
                        force = screw_force(state, step)
                        if force * state.contact > 0.0 and speed * state.contact > 0.0:
                            drives[5] += felt * force
                    if cogs > 0.0 and abs(speed) < COGGED_SPEED:
                        sine, cosine = cog_wave((state.motor.angle - 0.5 * turned) * cogs)
                        drives[6] += felt * sine
                        drives[7] += felt * cosine
                    drives[8] += sign * felt * lasted
                    drives[9] += sign * felt * covered
                    if lags and k > 0:
                        drives[11] += felt * per_lag[k - 1]
                    if holds:
                        per_drive = (1.0 - ahead * bend) * per_turn
                        yields_by = 1.0 / (1.0 + felt * size * per_drive)
                        for drive in range(DRIVE_COUNT):
                            moved = drives[drive] - driven[drive]
                            moved = yields_by * (moved - felt * size * bent_by[drive])
                            drives[drive] = driven[drive] + moved
                            bent_by[drive] += per_drive * moved
                angle = state.theta_d
                if angle != before:
                    last_side = 1.0 if angle > before else -1.0
                    last_motor, last_sample = state.motor.angle, float(k)
                    last_drives[:] = drives
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
                motor_angle[k] = state.motor.angle
                angles += angle
                sides += last_side
                motors += last_motor
                samples += last_sample
            blocks[0, number], blocks[1, number] = part * angles, part * sides
            blocks[2, number], blocks[3, number] = part * motors, part * samples
            blocks[4, number], blocks[5, number], blocks[6, number] = fast, slow, contact
            for drive in range(DRIVE_COUNT):
                blocks[7 + drive, number] = 0.5 * (begun[drive] + last_drives[drive])
        return found, travel

    return window_loop
