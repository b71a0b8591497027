"""How far each claim survives when what the paper leaves open is chosen differently."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bdt_analysis.figures import figure_style as style
from bdt_controller.pid import PidGains
from bdt_study.engine.function_map import mapped
from bdt_study.engine.job import Engine
from bdt_study.reproduction.claims import CLAIMS, Claim
from bdt_study.reproduction.experiments import Choices, run_paper


@dataclass(frozen=True)
class OpenChoice:
    """One thing that the paper leaves open, with other values for it.

    Attributes
    ----------
    name : str
        What is chosen, with its unit.
    chosen : float
        The package's choice.
    values : tuple of float
        Values to try, increasing, with the choice among them.
    apply : callable
        Makes the choices with a value.
    """

    name: str
    chosen: float
    values: tuple[float, ...]
    apply: Callable[[float], Choices]


def open_choices() -> tuple[OpenChoice, ...]:
    """Return what the paper leaves open: gap profile, amplitude, durations, gains, window."""
    default = Choices()
    gap = default.gap
    return (
        OpenChoice(
            "amplitude [mm]",
            1e3 * default.amplitude,
            (0.5, 1.0, 2.0, 5.0, 10.0, 20.0),
            lambda value: replace(default, amplitude=1e-3 * value),
        ),
        OpenChoice(
            "gap at the end [deg]",
            math.degrees(gap.final),
            (5.0, 10.0, 20.0, 30.0, 45.0, 60.0),
            lambda value: replace(default, gap=replace(gap, final=math.radians(value))),
        ),
        OpenChoice(
            "exponent of growth, mean gap 10°",
            gap.exponent,
            (0.5, 1.0, 2.0, 3.0),
            lambda value: replace(
                default,
                gap=replace(gap, exponent=value, final=math.radians(10.0 * (value + 1.0))),
            ),
        ),
        OpenChoice(
            "length of a step [s]",
            default.step_time,
            (5.0, 7.5, 10.0, 15.0, 20.0),
            lambda value: replace(default, step_time=value),
        ),
        OpenChoice(
            "factor on all gains",
            1.0,
            (0.6, 0.8, 0.9, 1.0, 1.1, 1.2, 1.35),
            lambda value: replace(default, gains=_scaled(default.gains, value)),
        ),
        OpenChoice(
            "estimator window [s]",
            default.window,
            (0.5, 1.0, 2.0, 3.0, 5.0, 10.0),
            lambda value: replace(default, window=value),
        ),
    )


def _scaled(gains: PidGains, factor: float) -> PidGains:
    return PidGains(
        factor * gains.proportional,
        factor * gains.integral,
        factor * gains.derivative,
        gains.filter_time,
    )


@dataclass(frozen=True)
class ClaimRobustness:
    """The claims for each value of one choice.

    Attributes
    ----------
    choice : OpenChoice
        What was changed, everything else as chosen.
    claims : tuple of tuple of Claim
        For each value the claims, in the order of ``CLAIMS``.
    """

    choice: OpenChoice
    claims: tuple[tuple[Claim, ...], ...]

    def holding(self, number: int) -> list[float]:
        """Return the values for which the claim with this number holds."""
        return [
            value
            for value, claims in zip(self.choice.values, self.claims, strict=True)
            if claims[number].holds
        ]


def sweep_choices(engine: Engine, choices: Sequence[OpenChoice]) -> tuple[ClaimRobustness, ...]:
    """Ask all claims again for each value of each choice.

    Parameters
    ----------
    engine : Engine
        What works on it.
    choices : sequence of OpenChoice
        The choices.
    """
    variations = [choice.apply(value) for choice in choices for value in choice.values]
    answers = list(mapped(engine, _claims, variations))
    robustness_results = []
    for choice in choices:
        count = len(choice.values)
        robustness_results.append(ClaimRobustness(choice, tuple(answers[:count])))
        answers = answers[count:]
    return tuple(robustness_results)


def robustness_figure(robustness_results: Sequence[ClaimRobustness]) -> Figure:
    """Return one panel a choice: a dot where a claim holds, a cross where it does not."""
    columns = 3
    rows = -(-len(robustness_results) // columns)
    with style.house_style():
        figure = style.new_figure(9.6, 0.6 + 2.5 * rows)
        panels = figure.subplots(rows, columns, sharey=True, squeeze=False)
        for axes, robustness in zip(panels.flat, robustness_results, strict=False):
            _draw(axes, robustness)
        for axes in panels.flat[len(robustness_results) :]:
            axes.set_visible(False)
        names = [claim.id for claim in robustness_results[0].claims[0]]
        panels[0, 0].set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
        panels[0, 0].set_ylim(len(names) - 0.5, -0.5)
        style.fix_layout(figure)
    return figure


def _draw(axes: Axes, robustness: ClaimRobustness) -> None:
    values = robustness.choice.values
    for place, claims in enumerate(robustness.claims):
        for row, claim in enumerate(claims):
            looks = (
                {"marker": "o", "color": style.POSITION, "ms": 6}
                if claim.holds
                else {"marker": "x", "color": style.ALARM_INK, "ms": 7, "mew": 2.2}
            )
            axes.plot([place], [row], ls="", **looks)  # type: ignore[arg-type]
    axes.set_xticks(range(len(values)), [f"{value:g}" for value in values])
    chosen = min(range(len(values)), key=lambda k: abs(values[k] - robustness.choice.chosen))
    axes.axvspan(chosen - 0.4, chosen + 0.4, color=style.WINDOW, lw=0, zorder=0)
    axes.set_xlim(-0.6, len(values) - 0.4)
    axes.set_xlabel(robustness.choice.name)


def _claims(choices: Choices) -> tuple[Claim, ...]:
    runs = run_paper(choices)
    return tuple(claim(runs) for claim in CLAIMS)
