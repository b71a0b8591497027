"""Eq. 9, decisions by simulation and an oracle: bias and settling over the gap.

The paper's summary promises a dead zone that is "tuned based on a digital twin to ensure the
closed-loop asymptotical stability and to avoid over-conservative design"; eq. 9 is its rule for it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bdt_analysis.figures import figure_style as style
from bdt_plant.gap_profile import GapProfile
from bdt_study.design.tuned_gains import TUNED_GAINS
from bdt_study.engine.function_map import mapped
from bdt_study.engine.job import Engine
from bdt_study.reproduction.claims import Claim
from bdt_study.reproduction.experiments import (
    Choices,
    Experiment,
    constant_experiment,
    reconfigured_experiment,
)
from bdt_twin.decision_settings import DecisionSettings

FloatArray = NDArray[np.float64]

GAPS = (5.0, 10.0, 15.0, 20.0, 28.0)
"""Constant gaps [deg]."""
STEPS = 19
"""Steps of a run: where a step comes to rest in the dead zone is a matter of chance. The first one
is not judged: before its reversals nobody knows the gap."""
ORACLE_RATIOS = tuple(k / 20 for k in range(20, 3, -1))
"""Dead zones that the oracle tries, over that of eq. 9."""
LARGEST_BIAS = 0.9
"""Worst bias at the largest gap that a decision by simulation is to have [% of the amplitude]."""

EQUATION_9, SIMULATED, REDESIGNED, ORACLE = "eq. 9", "simulated", "with redesigned gains", "oracle"
WAYS = (EQUATION_9, SIMULATED, REDESIGNED, ORACLE)
DECIDES = DecisionSettings(kind="simulate", period=40.0)
"""A constant gap needs few simulations."""


@dataclass(frozen=True)
class DecisionOutcome:
    """Runs of one way to decide at one gap.

    Attributes
    ----------
    way : str
        How the dead zone is decided on.
    gap : float
        True gap [deg].
    bias : float
        Worst bias [% of the amplitude].
    settling : float
        Median settling time [s]; infinite if the median step does not settle.
    limit_cycles : int
        Number of steps that end in a limit cycle.
    width : float
        Widest dead zone after the first step [% of the amplitude]: where in it a step comes to rest
        is chance, so this is the bias that it may have.
    """

    way: str
    gap: float
    bias: float
    settling: float
    limit_cycles: int
    width: float


def sweep_decisions(
    engine: Engine, choices: Choices, gaps: Sequence[float] = GAPS
) -> tuple[DecisionOutcome, ...]:
    """Run all ways to decide on the nominal mechanism with constant gaps.

    Parameters
    ----------
    engine : Engine
        What works on it.
    choices : Choices
        What the paper leaves open; its gap and duration are replaced.
    gaps : sequence of float
        Gaps [deg].
    """
    return tuple(mapped(engine, partial(_outcome, choices), product(gaps, WAYS)))


def decisions_are_stable(outcomes: Sequence[DecisionOutcome]) -> Claim:
    """Summary: the twin ensures asymptotical stability."""
    cycles = sum(each.limit_cycles for each in outcomes if each.way in (SIMULATED, REDESIGNED))
    return Claim(
        "decision_stable",
        "A dead zone tuned by the digital twin ensures asymptotical stability.",
        float(cycles),
        "steps with a limit cycle",
        cycles == 0,
        "dead zones decided on by simulation, with the gains as they are and with redesigned ones, "
        f"at all {len({each.gap for each in outcomes})} gaps; none",
    )


def decisions_are_not_conservative(outcomes: Sequence[DecisionOutcome]) -> Claim:
    """Summary: and avoids over-conservative design."""
    widest = max(each.gap for each in outcomes)
    worst = {each.way: each.bias for each in outcomes if each.gap == widest}
    widths = {each.way: each.width for each in outcomes if each.gap == widest}
    others = "; ".join(
        f"{way}: {worst[way]:.2g} % in a dead zone of {widths[way]:.2g} %" for way in worst
    )
    return Claim(
        "decision_not_conservative",
        "Tuned by the digital twin, the dead zone avoids over-conservative design.",
        worst[REDESIGNED],
        "% of the amplitude",
        worst[REDESIGNED] <= LARGEST_BIAS,
        f"worst bias with dead zone and gains decided on by simulation at {widest:g}°; at most "
        f"{LARGEST_BIAS:g} % ({others})",
    )


def decision_figure(outcomes: Sequence[DecisionOutcome]) -> Figure:
    """Return worst bias and settling time over the gap for all ways to decide."""
    colors = {
        EQUATION_9: style.DEAD_ZONE,
        SIMULATED: style.POSITION,
        REDESIGNED: style.ALARM_INK,
        ORACLE: style.FAINT,
    }
    with style.house_style():
        figure = style.new_figure(9.6, 3.4)
        panels = figure.subplots(1, 2, sharex=True)
        for way, color in colors.items():
            own = [each for each in outcomes if each.way == way]
            gaps = [each.gap for each in own]
            panels[0].plot(gaps, [each.width for each in own], color=color, ls=":", lw=1.2)
            for axes, values in (
                (panels[0], [each.bias for each in own]),
                (panels[1], [each.settling for each in own]),
            ):
                axes.plot(gaps, values, color=color, marker="o", ms=4, lw=1.2, label=way)
                failed = [number for number, each in enumerate(own) if each.limit_cycles]
                axes.plot(
                    [gaps[number] for number in failed],
                    [values[number] for number in failed],
                    color=color,
                    marker="X",
                    ms=9,
                    ls="",
                )
        for axes, label in (
            (panels[0], "worst bias [% of the amplitude]"),
            (panels[1], "median settling time [s]"),
        ):
            axes.set_xlabel("gap [deg]")
            axes.set_ylabel(label)
            axes.set_ylim(bottom=0.0)
        panels[0].legend(loc="upper left")
        style.fix_layout(figure)
    return figure


def _outcome(choices: Choices, gap_and_way: tuple[float, str]) -> DecisionOutcome:
    gap, way = gap_and_way
    run = _run(choices, math.radians(gap), way)
    times = run.settling_times[1:]
    return DecisionOutcome(
        way,
        gap,
        float(run.biases[1:].max()),
        float(np.median(np.where(np.isfinite(times), times, np.inf))),
        int(run.limit_cycles[1:].sum()),
        100.0 * float(_in_force(run, choices.step_time).max()) / choices.amplitude,
    )


def _run(choices: Choices, gap: float, way: str) -> Experiment:
    changed = replace(
        choices,
        gap=GapProfile(kind="constant", initial=gap),
        duration=STEPS * choices.step_time,
    )
    if way == EQUATION_9:
        return constant_experiment(changed, gap)
    if way == SIMULATED:
        return reconfigured_experiment(changed, decision=DECIDES)
    if way == REDESIGNED:
        redesigning = replace(DECIDES, reconfigure_gains=True)
        return reconfigured_experiment(changed, decision=redesigning, redesign=TUNED_GAINS)
    return _oracle(changed, gap)


def _oracle(choices: Choices, gap: float) -> Experiment:
    """Return the run with the narrowest dead zone next to eq. 9 that has no limit cycle.

    Who knows the mechanism and what is to come simulates the very run.
    """
    best = constant_experiment(choices, gap)
    for ratio in ORACLE_RATIOS[1:]:
        run = constant_experiment(choices, ratio * gap)
        if run.limit_cycles[1:].any():
            break
        best = run
    return best


def _in_force(run: Experiment, begin: float) -> FloatArray:
    """Return the dead zones that are in force from a time [s] on [m]."""
    times, tolerances = run.signals.dead_zones.T
    first = max(int(np.searchsorted(times, begin, side="right")) - 1, 0)
    return np.asarray(tolerances[first:])
