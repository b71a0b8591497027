"""The twin's model of the plant for factors and effects that a fit is looking for."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import FULL_TURN, float_exponential, sine_of_turns
from bdt_plant.plant import PlantModel
from bdt_plant.resisted_motor import resisted_motor
from bdt_plant.screw_load import ScrewLoad
from bdt_plant.stribeck import FrictionLaw
from bdt_twin.machine_knowledge import EFFECTS, USUAL_STRIBECK_SPEED
from bdt_twin.model_factors import FACTORS, motor_step_with, plant_step_with
from bdt_twin.resisted_plant import NO_COGS, Cogs, ResistedPlant
from bdt_twin.unknowns import SMALLEST_YIELD_ANGLE

FloatArray = NDArray[np.float64]
Wave = TypeVar("Wave", float, NDArray[np.float64])

LONGEST_PART = 2e-4
"""Time in which a motor with rigid friction may stop, turn or break loose in a single step [s]."""
LEAST_HOLDING = 1e-3
"""Voltage of the friction from which on it matters when the motor does so within a sample [V]."""


def resisted_plant_with(
    model: PlantModel,
    factors: FloatArray,
    effects: FloatArray,
    sample_time: float,
    longest_part: float = LONGEST_PART,
) -> ResistedPlant:
    """Return the discrete model of the plant with its factors and effects.

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism without factors.
    factors : ndarray, shape (3,)
        Natural logarithms of ``model_factors.FACTORS``.
    effects : ndarray, shape (effects,)
        ``machine_knowledge.EFFECTS``.
    sample_time : float
        Sample time [s].
    longest_part : float
        Time in which a motor with rigid friction may stop, turn or break loose in one step [s];
        infinite for samples that are taken in one step, whatever happens.
    """
    effect = dict(zip(EFFECTS, effects.tolist(), strict=True))
    resistance = float(model.motor.resistance)
    current = effect["friction_voltage"] / resistance
    plant = plant_step_with(model, np.append(factors, effect["top_mass"]), sample_time)
    plant = plant._replace(friction=plant.friction._replace(current=current))
    yields = effect["yield_angle"] >= SMALLEST_YIELD_ANGLE
    # Springs that yield take up what the motor does within a sample.
    is_held = effect["friction_voltage"] >= LEAST_HOLDING and not yields
    parts = max(round(sample_time / longest_part), 1) if is_held else 1
    motor = in_part = resisted_motor(plant.motor, model.motor, sample_time)
    if parts > 1:
        part_time = sample_time / parts
        in_part = resisted_motor(motor_step_with(model, factors, part_time), model.motor, part_time)
    speed = USUAL_STRIBECK_SPEED * float_exponential(effect["stribeck_speed"])
    friction = FrictionLaw(current, effect["excess_voltage"] / resistance, speed, 1.0, 1.0)
    ratios = dict(zip(FACTORS, map(float_exponential, factors.tolist()), strict=True))
    return ResistedPlant(
        plant,
        motor,
        friction,
        ScrewLoad(effect["load_voltage"] / resistance, 0.0),
        model.structure.stiffness * ratios["stiffness"],
        model.structure.damping * ratios["damping"],
        NO_COGS,
        effect["yield_angle"] if yields else 0.0,
        sample_time,
        parts,
        in_part,
    )


def with_cogs(step: ResistedPlant, cogs: int, turns: float, effects: FloatArray) -> ResistedPlant:
    """Return a model with the cogging of a stretch of data.

    Parameters
    ----------
    step : ResistedPlant
        The model without.
    cogs : int
        Periods of the cogging in a turn of the motor; 0 for none.
    turns : float
        Part of a cog's period at which the screw is when the stretch begins.
    effects : ndarray, shape (effects,)
        ``machine_knowledge.EFFECTS``.
    """
    if cogs == 0:
        return step
    effect = dict(zip(EFFECTS, effects.tolist(), strict=True))
    sine, cosine = rotated(effect["cogging_sine"], effect["cogging_cosine"], turns)
    resistance = step.motor.resistance
    return step._replace(cogs=Cogs(cogs / FULL_TURN, sine / resistance, cosine / resistance))


def rotated(sine: Wave, cosine: Wave, turns: float) -> tuple[Wave, Wave]:
    """Return the parts of a wave of an angle that begins some turns later."""
    real, imaginary = sine_of_turns(turns + 0.25), sine_of_turns(turns)
    return sine * real - cosine * imaginary, sine * imaginary + cosine * real
