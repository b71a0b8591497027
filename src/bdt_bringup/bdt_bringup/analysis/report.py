"""The report: one HTML file with verdict, tables and figures that needs nothing else."""

import math
from dataclasses import dataclass

from bdt_bringup.analysis.reference_steps import ReferenceStep
from bdt_bringup.analysis.step_analysis import StepSummary
from bdt_bringup.analysis.summary import Summary
from bdt_bringup.bags.recording import Recording
from bdt_bringup.pages.rendering import render_page

MISSING = "–"  # noqa: RUF001 - a dash stands for an unknown value
MOST_ROWS = 200
"""Number of steps that the table shows."""


@dataclass(frozen=True)
class Verdict:
    """The result in words.

    Attributes
    ----------
    good : bool
        True when every step was judged and none ends in a limit cycle.
    headline : str
        The answer: is the loop stable?
    details : str
        Worst bias and worst gap error.
    """

    good: bool
    headline: str
    details: str


def verdict(summary: Summary) -> Verdict:
    """Return the result of a run in words.

    Parameters
    ----------
    summary : Summary
        The numbers.
    """
    judged = [step for step in summary.steps if step.limit_cycle is not None]
    cycles = summary.limit_cycles
    lost = [step for step in summary.steps if abs(step.bias_percent_of_amplitude or 0.0) > 100.0]
    if lost:
        headline = (
            f"Not stable: the position is off by more than the step in {_steps(len(lost))}, "
            f"first in the one that begins at {lost[0].t_start_s:.6g} s"
        )
    elif not judged:
        headline = "No step could be judged"
    elif cycles:
        headline = (
            f"Not stable: limit cycle in {len(cycles)} of {_steps(len(judged))}, "
            f"first in the one that begins at {cycles[0].t_start_s:.6g} s"
        )
    else:
        headline = f"Stable throughout: no limit cycle in {_steps(len(judged))}"
    left_out = len(summary.steps) - len(judged)
    if judged and left_out:
        headline += f" ({left_out} not judged)"
    return Verdict(
        bool(judged) and not cycles and not lost, headline, "; ".join(_details(summary)) + "."
    )


def _steps(count: int) -> str:
    return "one step" if count == 1 else f"{count} steps"


def _details(summary: Summary) -> list[str]:
    parts = []
    worst = summary.worst_bias
    if worst is not None:
        parts.append(
            f"worst bias {abs(worst.bias_percent_of_amplitude or 0.0):.2f} % of the step amplitude "
            f"(step at {worst.t_start_s:.6g} s)"
        )
    errors = summary.estimate
    if errors.max_error_rad is not None and errors.rms_error_rad is not None:
        parts.append(
            f"gap estimate off by {math.degrees(errors.max_error_rad):.2f}° at worst, "
            f"{math.degrees(errors.rms_error_rad):.2f}° rms"
        )
    else:
        parts.append("gap error unknown: the bag lacks truth or estimates")
    if summary.lost_messages:
        parts.append(f"{summary.lost_messages} messages lost")
    return parts


def render_report(
    recording: Recording,
    steps: list[ReferenceStep],
    summary: Summary,
    overview: str,
    residuals: str | None,
) -> str:
    """Return the text of ``report.html``.

    Parameters
    ----------
    recording : Recording
        The run.
    steps : list of ReferenceStep
        Its steps.
    summary : Summary
        What was found.
    overview, residuals : str
        The figures as SVG elements; None for a figure without content.
    """
    shown = summary.steps[:MOST_ROWS]
    return render_page(
        "report.html",
        name=recording.path.resolve().name,
        path=str(recording.path),
        verdict=verdict(summary),
        tiles=_tiles(summary),
        overview=overview,
        residuals=residuals,
        steps=[_step_row(k, step) for k, step in enumerate(shown, start=1)],
        hidden_steps=len(summary.steps) - len(shown),
        windows=sorted({f"{step.window:.3g}" for step in steps}),
        cut=bool(steps) and steps[-1].cut,
        estimate=_estimate_rows(recording, summary),
        messages=summary.messages,
        lost=summary.lost_messages,
    )


def _tiles(summary: Summary) -> list[tuple[str, str, str]]:
    bias, residual, errors = summary.worst_bias, summary.worst_residual, summary.estimate
    return [
        (
            "worst bias",
            _number(abs(bias.bias_percent_of_amplitude or 0.0) if bias else None, 1, ".2f"),
            "%",
        ),
        (
            "worst residual p-p",
            _number(residual.residual_peak_to_peak_m if residual else None, 1e6, ".3g"),
            "µm",
        ),
        ("gap error, rms", _number(errors.rms_error_rad, math.degrees(1), ".2f"), "deg"),
        ("reconfigurations", str(summary.reconfigurations), ""),
        ("simulated time", _number(summary.duration_s, 1, ".5g"), "s"),
        ("pace", _number(summary.real_time_factor, 1, ".3g"), "× real time"),  # noqa: RUF001
    ]


def _step_row(number: int, step: StepSummary) -> dict[str, str | bool]:
    cycle = {None: MISSING, False: "no", True: "yes"}[step.limit_cycle]
    return {
        "number": str(number),
        "start": _number(step.t_start_s, 1, ".6g"),
        "reference": _number(step.reference_m, 1e3, ".4g"),
        "residual": _number(step.residual_peak_to_peak_m, 1e6, ".2f"),
        "bias": _number(step.bias_m, 1e6, "+.2f"),
        "percent": _number(step.bias_percent_of_amplitude, 1, "+.3f"),
        "settling": _number(step.settling_time_s, 1, ".2f"),
        "cycle": cycle,
        "alarm": bool(step.limit_cycle),
    }


def _estimate_rows(recording: Recording, summary: Summary) -> list[tuple[str, str, str]]:
    """Return rows of (quantity, value, unit)."""
    degrees, errors = math.degrees(1), summary.estimate
    final = summary.dead_zone_final_m
    angle = None if final is None else final / recording.pitch
    gap = None if recording.truth is None else float(recording.truth[-1, 3])
    return [
        ("estimates", str(len(recording.estimates)), ""),
        ("gap error, root mean square", _number(errors.rms_error_rad, degrees, ".3f"), "deg"),
        ("gap error, largest", _number(errors.max_error_rad, degrees, ".3f"), "deg"),
        ("worst lag of the dead zone", _number(errors.worst_lag_s, 1, ".3f"), "s"),
        ("reconfigurations", str(summary.reconfigurations), ""),
        ("dead zone at the end", _number(final, 1e6, ".2f"), "µm"),
        ("dead zone at the end, as a gap", _number(angle, degrees, ".2f"), "deg"),
        ("true gap at the end", _number(gap, degrees, ".2f"), "deg"),
    ]


def _number(value: float | None, scale: float, form: str) -> str:
    if value is None:
        return MISSING
    return format(value * scale, form).replace("-", "−")  # noqa: RUF001 - a minus sign
