"""The time by which a motor answers late, where the start value of it may be far too large.

Voltage and position tell it together with the age of a reading. With an inertia that is too large
the reading would have to be early.
"""

from dataclasses import replace

from bdt_plant.plant import PlantModel
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.unknowns import Unknowns

SMALLEST_LAG = 1e-4
"""Time by which a motor answers late at least [s], as far as a calibration tells."""


def motor_lag(model: PlantModel) -> float:
    """Return the time by which the motor answers late, R J / (k_B k_T) [s]."""
    motor = model.motor
    return motor.resistance * motor.inertia / (motor.back_emf_constant * motor.torque_constant)


def with_lag(model: PlantModel, lag: float) -> PlantModel:
    """Return the mechanism with a motor whose inertia makes it answer late by a time [s]."""
    inertia = model.motor.inertia * lag / motor_lag(model)
    return replace(model, motor=replace(model.motor, inertia=inertia))


def without_early_reading(model: PlantModel, unknowns: Unknowns) -> tuple[PlantModel, Unknowns]:
    """Return a mechanism that answers as soon, and no reading that is there before its time.

    Parameters
    ----------
    model : PlantModel
        The mechanism.
    unknowns : Unknowns
        What goes with it; a delay that is not negative stays, and so does the mechanism.
    """
    place = EFFECTS.index("delay")
    delay, before = float(unknowns.effects[place]), motor_lag(model)
    if delay >= 0.0 or before <= SMALLEST_LAG:
        return model, unknowns
    lag = max(before + delay, SMALLEST_LAG)
    effects = unknowns.effects.copy()
    effects[place] = delay + before - lag
    return with_lag(model, lag), replace(unknowns, effects=effects)
