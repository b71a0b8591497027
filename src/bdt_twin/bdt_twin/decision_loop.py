"""The closed loop as the twin simulates it: the steps of the plant and of the controller, compiled.

Motor, play and structure are those of :mod:`bdt_plant`, the law is that of
:mod:`bdt_controller.control_law`; here is nothing but the loop around them.
"""

from functools import cache, lru_cache
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_controller.control_law import (
    INITIAL_CONTROL,
    ControlLaw,
    control_step,
    discretize_control,
)
from bdt_controller.pid import PidGains
from bdt_plant.compilation import compile_with_steps
from bdt_plant.lead_screw import contact_side
from bdt_plant.plant import (
    AT_REST,
    DiscretePlant,
    PlantModel,
    PlantState,
    discretize_plant,
    plant_step,
)

FloatArray = NDArray[np.float64]

HOLD = 2
"""Samples of the plant in a control period: contact is late by a millisecond at most."""


class Member(NamedTuple):
    """A mechanism that the twin thinks possible.

    Attributes
    ----------
    plant : DiscretePlant
        Its discrete model, `HOLD` samples a control period.
    gap : float
        Backlash gap theta_b [rad].
    disturbance : float
        Voltage that the amplifier adds and nobody takes back [V].
    lag : int
        Age of a reading in samples.
    place : float
        Where the motor rests in the gap at first, -1 to 1.
    noise : float
        Standard deviation of the noise of a reading [m].
    """

    plant: DiscretePlant
    gap: float
    disturbance: float
    lag: int
    place: float
    noise: float = 0.0


# Steps have as many lengths as a loop has, and a twin runs for long.
@lru_cache(maxsize=4)
def noise_draws(count: int) -> FloatArray:
    """Return the noise of readings in standard deviations, the same each time, shape (count,)."""
    return np.random.default_rng(20_261_122).standard_normal(count)


def simulate_steps(
    member: Member, law: ControlLaw, tolerance: float, limit: float, references: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return position and activity of a loop that begins at rest.

    Parameters
    ----------
    member : Member
        The mechanism.
    law : ControlLaw
        Controller.
    tolerance : float
        Dead-zone tolerance epsilon_dz [m].
    limit : float
        Voltage limit of the controller [V]; 0 for none.
    references : ndarray, shape (n,)
        Reference r at each measurement [m].

    Returns
    -------
    positions : ndarray, shape (n,)
        q3 at each measurement [m].
    voltages : ndarray, shape (n,)
        Voltage commanded at each measurement [V].
    """
    angle = 0.5 * member.gap * member.place
    motor = AT_REST.motor._replace(angle=angle)
    state = AT_REST._replace(motor=motor, contact=contact_side(0.0, angle, member.gap))
    positions, voltages = np.empty(references.size), np.empty(references.size)
    line = np.zeros(member.lag + 1)
    # What the controller wants of the readings, so that noise is no business of the loop.
    wanted = references - member.noise * noise_draws(references.size)
    compiled_steps()(
        state,
        member.plant,
        law,
        wanted,
        tolerance,
        member.gap,
        limit,
        member.disturbance,
        line,
        positions,
        voltages,
    )
    return positions, voltages


@cache
def compiled_steps() -> Any:
    """Return the loop over control periods, compiled."""

    def signature() -> Any:
        # Imported here, because it is absent on many a small computer.
        numba = import_module("numba")
        types, typeof = numba.types, numba.typeof
        given = types.Array(types.float64, 1, "C", readonly=True)
        signal = types.Array(types.float64, 1, "C")
        return (
            typeof(AT_REST),
            typeof(discretize_plant(PlantModel(), 1e-3)),
            typeof(discretize_control(PidGains(), 2e-3)),
            given,
            *(types.float64 for _ in range(4)),
            signal,
            signal,
            signal,
        )

    return compile_with_steps(_steps_loop, [plant_step, control_step], signature)


def _steps_loop(sources: str) -> Any:
    def steps_loop(
        plant: PlantState,
        step: DiscretePlant,
        law: ControlLaw,
        references: FloatArray,
        tolerance: float,
        gap: float,
        limit: float,
        disturbance: float,
        line: FloatArray,
        positions: FloatArray,
        voltages: FloatArray,
    ) -> None:
        _ = sources
        control = INITIAL_CONTROL
        newest = 0
        for k in range(references.size):
            # The line holds the newest position and those that are not yet read.
            oldest = (newest + 1) % line.size
            error = references[k] - line[oldest]
            control, voltage = control_step(control, error, tolerance, law, limit, 0.0)
            positions[k] = plant.structure.q3
            voltages[k] = voltage
            for _sample in range(HOLD):
                plant = plant_step(plant, voltage + disturbance, gap, step)
                newest = (newest + 1) % line.size
                line[newest] = plant.structure.q3

    return steps_loop
