"""What the paper asks of the PID: no steady-state error, bandwidth, phase margin."""

import math

from bdt_plant.plant import PlantModel
from bdt_study.design.linear_model import loop_transfer
from bdt_study.design.loop_margins import loop_margins
from bdt_study.reproduction.claims import Claim
from bdt_study.reproduction.experiments import Choices
from bdt_study.simulation.closed_loop import Scenario, simulate

BANDWIDTH = 10.0
"""Bandwidth frequency [rad/s]."""

SMALLEST_PHASE_MARGIN = 10.0
"""Phase margin [deg]."""

SETTLED_AFTER = 20.0
"""Time after which the error of a step counts as the steady-state error [s]."""


def design_claims(choices: Choices) -> tuple[Claim, ...]:
    """Return the claims about the linear controller without backlash.

    Parameters
    ----------
    choices : Choices
        Its gains and amplitude count.
    """
    margins = loop_margins(loop_transfer(PlantModel(), choices.gains))
    margin = math.degrees(margins.smallest_phase_margin)
    scenario = Scenario(
        duration=SETTLED_AFTER, reference=choices.amplitude, gap=0.0, gains=choices.gains
    )
    error = abs(float(simulate(scenario, ("q3",)).q3[-1]) - choices.amplitude)
    percent = 100 * error / choices.amplitude
    return (
        Claim(
            "design_zero_steady_state_error",
            "The PID achieves a zero steady-state error.",
            percent,
            "% of the amplitude",
            percent < 1e-6,
            f"without backlash, {SETTLED_AFTER:g} s after a step; below 1e-6 %",
        ),
        Claim(
            "design_bandwidth",
            "The PID achieves a bandwidth frequency of 10 rad/s.",
            margins.first_crossover,
            "rad/s",
            abs(margins.first_crossover - BANDWIDTH) < 0.1,
            "first gain crossover of the continuous loop, the meaning taken here; -3 dB of T: "
            f"{margins.bandwidth:.3g} rad/s",
        ),
        Claim(
            "design_phase_margin",
            "The PID achieves a minimum phase margin of 10 degrees.",
            margin,
            "deg",
            margins.stable and margin >= SMALLEST_PHASE_MARGIN,
            f"smallest over all {len(margins.crossovers)} gain crossovers, closed loop stable",
        ),
    )
