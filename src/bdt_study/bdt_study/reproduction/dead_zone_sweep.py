"""The dead-zone tolerance against a constant gap: too narrow fails, too wide costs bias."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from matplotlib.figure import Figure

from bdt_analysis.figures import figure_style as style
from bdt_plant.gap_profile import GapProfile
from bdt_study.engine.function_map import mapped
from bdt_study.engine.job import Engine
from bdt_study.reproduction.experiments import Choices, constant_experiment

GAP = math.radians(20.0)
"""Constant true gap [rad]."""

RATIOS = (*(k / 8 for k in range(17)), 2.5, 3.0, 4.0)
"""Assumed gap of eq. 9 over the true gap."""

STEPS = 6
"""Number of steps in a run: levels alternate, and so do the ways in which q3 comes to rest."""


@dataclass(frozen=True)
class ToleranceOutcome:
    """Runs with one dead-zone tolerance.

    Attributes
    ----------
    ratio : float
        Assumed over true gap.
    residual : float
        Largest peak to peak at the end of a step [m].
    bias : float
        Worst bias [% of the amplitude].
    settling_time : float
        Mean settling time [s]; NaN when no step settles.
    limit_cycles : int
        Number of steps that end in a limit cycle.
    """

    ratio: float
    residual: float
    bias: float
    settling_time: float
    limit_cycles: int


def sweep_tolerances(
    engine: Engine, choices: Choices, ratios: Sequence[float] = RATIOS
) -> tuple[ToleranceOutcome, ...]:
    """Run the controller with constant dead zones at a constant gap of 20 degrees.

    Parameters
    ----------
    engine : Engine
        What works on it.
    choices : Choices
        What the paper leaves open; its gap and duration are replaced.
    ratios : sequence of float
        Assumed gaps, as multiples of the true one.
    """
    changed = replace(
        choices,
        gap=GapProfile(kind="constant", initial=GAP),
        duration=STEPS * choices.step_time,
    )
    return tuple(mapped(engine, partial(_outcome, changed), ratios))


def tolerance_figure(outcomes: Sequence[ToleranceOutcome]) -> Figure:
    """Return residual, bias and settling time over the tolerance."""
    ratios = [each.ratio for each in outcomes]
    with style.house_style():
        figure = style.new_figure(9.6, 3.4)
        panels = figure.subplots(1, 3, sharex=True)
        for axes, values, label in (
            (panels[0], [1e6 * each.residual for each in outcomes], "worst residual p-p [µm]"),
            (panels[1], [each.bias for each in outcomes], "worst bias [% of the amplitude]"),
            (panels[2], [each.settling_time for each in outcomes], "mean settling time [s]"),
        ):
            for each, value in zip(outcomes, values, strict=True):
                bad = each.limit_cycles > 0
                axes.plot(
                    [each.ratio],
                    [value],
                    marker="X" if bad else "o",
                    ms=7 if bad else 5,
                    color=style.ALARM_INK if bad else style.POSITION,
                )
            axes.plot(ratios, values, color=style.FAINT, lw=0.8, zorder=1)
            axes.axvline(1.0, color=style.FAINT, ls=":", lw=1.2)
            axes.set_ylabel(label)
            axes.set_xlabel("assumed gap / true gap")
        panels[0].set_yscale("log")
        panels[1].set_ylim(bottom=0.0)
        panels[0].plot([], [], color=style.ALARM_INK, marker="X", ls="", label="limit cycle")
        panels[0].plot([], [], color=style.POSITION, marker="o", ls="", label="none")
        panels[0].legend(loc="upper right")
        style.fix_layout(figure)
    return figure


def _outcome(choices: Choices, ratio: float) -> ToleranceOutcome:
    run = constant_experiment(choices, ratio * GAP)
    settled = run.settling_times[np.isfinite(run.settling_times)]
    return ToleranceOutcome(
        ratio,
        float(run.residuals.max()),
        float(run.biases.max()),
        float(settled.mean()) if settled.size else math.nan,
        int(run.limit_cycles.sum()),
    )
