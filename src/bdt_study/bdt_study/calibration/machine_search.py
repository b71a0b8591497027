"""Where the fit of a machine begins whose constants may be far off: the best of many places.

What a least-squares fit does not find by itself is a structure that rings at half the frequency, or
friction and a gap of another size: these are tried on a coarse copy of the data, the unlikely ones
only for a few steps.
"""

import math
from dataclasses import replace
from itertools import product

import numpy as np

from bdt_plant.friction import friction_voltage
from bdt_plant.plant import PlantModel
from bdt_study.calibration.calibration_window import CalibrationWindow
from bdt_study.calibration.fitted_data import SETTINGS, Data
from bdt_study.calibration.prior_knowledge import wide_knowledge, without_late_readings
from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import EFFECTS, MachineKnowledge
from bdt_twin.model_factors import FACTORS
from bdt_twin.output_error_fit import WindowFit
from bdt_twin.unknowns import Unknowns
from bdt_twin.window_search import (
    COARSE_BLOCK_RATE,
    COARSE_RATE,
    initial_conditions_at_rest,
)

FIRST_GAPS = (2.0, 8.0, 20.0)
"""Gaps from which the search begins [deg]."""
FIRST_STIFFNESSES = (0.5, 0.7, 1.0, 1.4, 2.0)
"""Factors on k/m from which it begins: ringing is found again within a fifth of its frequency."""
FIRST_FRICTIONS = (0.0, 0.2)
"""Voltages for the friction, beside the known one, from which it begins [V]."""
ROUGH_MISFIT = 0.25
"""Share of the motion that the best beginning may leave."""
OTHER_GAPS = (3.0, 8.0, 16.0, 28.0)
"""Gaps from which it begins again if noise of the machine is found [deg]."""
SURVIVORS = (12, 4, 2)
"""How many beginnings are left after each round of the search."""
ROUNDS = (2, 4, 8)
"""Steps of the fit in each round."""


def search_beginning(model: PlantModel, data: Data) -> Unknowns:
    """Return the most likely of many beginnings, on a coarse copy of the data.

    Parameters
    ----------
    model : PlantModel
        Start values.
    data : Data
        Telemetry.

    Raises
    ------
    ValueError
        If none explains the data even roughly.
    """
    coarse = data.window(model).coarse(COARSE_RATE, COARSE_BLOCK_RATE)
    friction = friction_voltage(model.motor)
    knowledge = wide_knowledge(friction)
    frictions = dict.fromkeys((friction, *FIRST_FRICTIONS))
    candidates = []
    for gap, stiffness, voltage in product(FIRST_GAPS, FIRST_STIFFNESSES, frictions):
        factors, effects = np.zeros(len(FACTORS)), np.zeros(len(EFFECTS))
        factors[FACTORS.index("stiffness")] = math.log(stiffness)
        effects[EFFECTS.index("friction_voltage")] = voltage
        gaps = np.full(coarse.knots.size, math.radians(gap))
        beginning = initial_conditions_at_rest(coarse)
        candidates.append(Unknowns(gaps, factors, beginning, effects))
    for number, (steps, survivors) in enumerate(zip(ROUNDS, SURVIVORS, strict=True)):
        is_last = number == len(ROUNDS) - 1
        prior = knowledge if is_last else without_late_readings(knowledge)
        problem = WindowFit(coarse, SETTINGS.growth_change, prior)
        fits = [problem.solve(each, steps, 2 * steps) for each in candidates]
        fits.sort(key=lambda fit: fit.residual)
        candidates = [fit.unknowns for fit in fits[:survivors]]
    motion = max(float(np.std(stretch.position)) for stretch in coarse.stretches)
    if not fits[0].residual <= ROUGH_MISFIT * motion:
        raise ValueError(
            f"the model does not explain {1e6 * fits[0].residual:.3g} um "
            f"of a motion of {1e6 * motion:.3g} um"
        )
    return candidates[0]


def fit_from_any_gap(
    window: CalibrationWindow, knowledge: MachineKnowledge, start: Unknowns, steps: int
) -> Fit:
    """Return the best fit of a coarse copy that allows for noise of the machine all along.

    Parameters
    ----------
    window : CalibrationWindow
        Model and data.
    knowledge : MachineKnowledge
        What is known of the machine before.
    start : Unknowns
        Where the fits begin, but for the gap and the readings' age and drift.
    steps : int
        Largest number of steps of a fit.
    """
    coarse = window.coarse(COARSE_RATE, COARSE_BLOCK_RATE)
    problem = WindowFit(coarse, SETTINGS.growth_change, without_late_readings(knowledge))
    beginning = initial_conditions_at_rest(coarse)
    effects = start.effects.copy()
    effects[[EFFECTS.index("delay"), EFFECTS.index("drift")]] = 0.0
    start, fits = replace(start, effects=effects), []
    for gap in OTHER_GAPS:
        gaps = np.full(coarse.knots.size, math.radians(gap))
        unknowns = replace(start, gaps=gaps, initial_conditions=beginning)
        levels = problem.solve(unknowns, 0, 1).levels
        fits.append(problem.solve(unknowns, steps, 3 * steps, levels=levels))
    return min(fits, key=lambda each: each.prediction_error)
