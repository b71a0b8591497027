"""What python-control says of a controller over all mechanisms, without backlash."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from bdt_plant.plant import PlantModel
from bdt_study.design.linear_model import sampled_loop_transfer
from bdt_study.design.loop_margins import loop_margins
from bdt_study.tuning.robust_design import ControllerDesign


@dataclass(frozen=True)
class LinearJudgment:
    """Margins of the sampled loop over some mechanisms.

    Attributes
    ----------
    stable : bool
        Whether the loop is stable with every mechanism.
    nominal_sensitivity, largest_sensitivity : float
        M_s with the first mechanism, and the largest over all.
    smallest_phase_margin : float
        Over all mechanisms and crossovers [rad].
    bandwidth : float
        First gain crossover with the first mechanism [rad/s].
    integrates : bool
        Whether the controller takes all error: K_i is positive.
    """

    stable: bool
    nominal_sensitivity: float
    largest_sensitivity: float
    smallest_phase_margin: float
    bandwidth: float
    integrates: bool


def judge(
    design: ControllerDesign, models: Sequence[PlantModel], control_rate: float
) -> LinearJudgment:
    """Judge a controller with python-control.

    Parameters
    ----------
    design : ControllerDesign
        The controller.
    models : sequence of PlantModel
        The mechanisms, the nominal one first.
    control_rate : float
        Rate of measurements [Hz].
    """
    margins = [
        loop_margins(sampled_loop_transfer(model, design.gains, control_rate, design.notch))
        for model in models
    ]
    stable = all(one.stable for one in margins)
    return LinearJudgment(
        stable,
        margins[0].maximum_sensitivity,
        max(one.maximum_sensitivity for one in margins) if stable else math.inf,
        min(one.smallest_phase_margin for one in margins) if stable else 0.0,
        margins[0].first_crossover,
        design.gains.integral > 0.0,
    )
