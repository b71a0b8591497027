"""The report: one HTML file with verdict, tables and figures that needs nothing else."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from bdt_analysis.figures.interactive import PlottedRun, interactive_part
from bdt_analysis.figures.plot_series import panels, run_series
from bdt_analysis.figures.run_figures import time_label
from bdt_analysis.metrics.recording_holes import RecordingHole
from bdt_analysis.metrics.reference_steps import ReferenceStep
from bdt_analysis.metrics.run_names import run_names
from bdt_analysis.metrics.summary import Summary
from bdt_analysis.pages.decision_table import decision_table
from bdt_analysis.pages.re_estimation_report import re_estimation_table
from bdt_analysis.pages.rendering import render_page
from bdt_analysis.pages.report_tables import detail_tables, steps_table
from bdt_analysis.pages.table import number
from bdt_analysis.pages.timing_tables import reconfiguration_table, timing_tables
from bdt_analysis.re_estimation.re_estimation import ReEstimation
from bdt_bags.reading.recording import Recording

LARGEST_BIAS = 5.0
"""Bias [% of the height] of a step beyond which the position has not come to the reference."""

MISSING = "–"  # noqa: RUF001 - a dash stands for an unknown value


@dataclass(frozen=True)
class Verdict:
    """The result in words.

    Attributes
    ----------
    good : bool
        True when a step was judged, none ends in a limit cycle, all end at the reference and
        nothing is missing.
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
    off = [
        step for step in summary.steps if abs(step.bias_percent_of_amplitude or 0.0) > LARGEST_BIAS
    ]
    lost = [step for step in off if abs(step.bias_percent_of_amplitude or 0.0) > 100.0]
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
    elif off:
        headline = (
            f"Not at the reference: the position stays off by more than {LARGEST_BIAS:g} % of the "
            f"step in {_steps(len(off))}, first in the one that begins at "
            f"{off[0].t_start_s:.6g} s"
        )
    else:
        how = "as far as it was recorded" if summary.holes else "throughout"
        headline = f"Stable {how}: no limit cycle in {_steps(len(judged))}"
    left_out = len(summary.steps) - len(judged)
    reasons = [f"{left_out} not judged"] if judged and left_out else []
    if summary.holes:
        reasons.append(f"{_missing_time(summary.holes):.3g} s are missing")
    if reasons:
        headline += f" ({', '.join(reasons)})"
    good = bool(judged) and not (cycles or off or summary.holes)
    return Verdict(good, headline, "; ".join(_details(summary)) + ".")


def _missing_time(holes: Sequence[RecordingHole]) -> float:
    """Return how long [s] something is missing; holes of several topics may overlap."""
    total, end = 0.0, -math.inf
    for hole in sorted(holes, key=lambda hole: hole.begins_s):
        total += max(hole.ends_s - max(hole.begins_s, end), 0.0)
        end = max(end, hole.ends_s)
    return total


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
    if errors.stated_max_error_rad is not None and errors.stated_rms_error_rad is not None:
        parts.append(
            f"gap estimates off by {math.degrees(errors.stated_max_error_rad):.3f}° at worst, "
            f"{math.degrees(errors.stated_rms_error_rad):.3f}° rms, at the times for "
            "which they are stated, and outgrown by up to "
            f"{math.degrees(errors.max_shortfall_rad or 0.0):.2f}° until the next one came"
        )
    else:
        parts.append("gap error unknown: the bag lacks truth or estimates")
    if summary.lost_messages:
        queue = summary.lost_in_queue
        where = f", {queue} of them in the queue of a recorder that was late" if queue else ""
        parts.append(f"{summary.lost_messages} messages lost{where}")
    return parts


def render_report(
    recording: Recording,
    steps: list[ReferenceStep],
    summary: Summary,
    overview: str,
    residuals: str | None,
    re_estimation: ReEstimation | None = None,
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
    re_estimation : ReEstimation, optional
        What an estimator made of the telemetry.
    """
    name = run_names([recording.path])[0]
    telemetry = recording.telemetry
    begin, end = telemetry[[0, -1], 0]
    run = PlottedRun(name, begin, end, steps, summary.steps, recording.marks)
    return render_page(
        "report.html",
        name=name,
        path=str(recording.path),
        verdict=verdict(summary),
        tiles=_tiles(summary),
        overview=overview,
        residuals=residuals,
        plots=interactive_part(
            panels(recording, steps),
            run_series(recording, steps, re_estimation=re_estimation),
            [run],
            time_label(recording),
        ),
        steps=steps_table(summary, steps),
        decisions=decision_table(summary.decisions),
        tables=detail_tables(recording, summary),
        timing=timing_tables([(name, summary)]),
        log=reconfiguration_table(recording),
        re_estimation=re_estimation_table(re_estimation.summary) if re_estimation else None,
        marks=[f"{time:.2f}" for time in recording.marks],
        missing=summary.missing,
        windows=sorted({f"{step.window:.3g}" for step in steps}),
    )


def _tiles(summary: Summary) -> list[tuple[str, str, str]]:
    bias, residual, errors = summary.worst_bias, summary.worst_residual, summary.estimate
    tiles = [
        (
            "worst bias",
            number(abs(bias.bias_percent_of_amplitude or 0.0) if bias else None, ".2f"),
            "%",
        ),
        (
            "worst residual p-p",
            number(residual.residual_peak_to_peak_m if residual else None, ".3g", 1e6),
            "µm",
        ),
        ("gap error, rms", number(errors.stated_rms_error_rad, ".3f", math.degrees(1)), "deg"),
        ("reconfigurations", number(summary.reconfigurations, ".0f"), ""),
        ("simulated time", number(summary.duration_s, ".5g"), "s"),
        ("pace", number(summary.real_time_factor, ".3g"), "× real time"),  # noqa: RUF001
    ]
    return [(label, value or MISSING, unit if value else "") for label, value, unit in tiles]
