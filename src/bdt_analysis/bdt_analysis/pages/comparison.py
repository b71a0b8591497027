"""Several runs side by side: their curves and tables."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bdt_analysis.figures.curves import Panel, Series
from bdt_analysis.figures.figure_style import RUNS
from bdt_analysis.figures.interactive import PlottedRun
from bdt_analysis.figures.plot_series import MOST_POINTS, panels, run_series
from bdt_analysis.metrics.compared_runs import ComparedRun
from bdt_analysis.pages.report_tables import STEP_COLUMNS, step_cells
from bdt_analysis.pages.table import Column, Row, Table, number

RUN_COLUMNS = (
    Column("run", text=True),
    Column("duration", "s"),
    Column("steps judged"),
    Column("limit cycles"),
    Column("first at", "s"),
    Column("worst bias", "% of amplitude"),
    Column("worst residual, peak to peak", "µm"),
    Column("gap error, rms", "deg"),
    Column("gap error, largest", "deg"),
    Column("gap shortfall", "deg"),
    Column("worst lag", "s"),
    Column("lost messages"),
)


def compared_panels(runs: Sequence[ComparedRun]) -> list[Panel]:
    """Return the plots, with the scale of the error that fits the run with most left."""
    all_panels = [panels(run.recording, run.steps) for run in runs]
    return [
        max(group, key=lambda panel: (panel.range or (0, 0))[1])
        for group in zip(*all_panels, strict=True)
    ]


def compared_series(runs: Sequence[ComparedRun]) -> list[Series]:
    """Return the curves of all runs: one color a run, the kinds of curves told by their dashes.

    The page holds as much of all runs together as of a single one.
    """
    series: list[Series] = []
    for k, run in enumerate(runs):
        for curve in run_series(run.recording, run.steps, MOST_POINTS // len(runs)):
            if curve.panel == "error" and curve.steps:
                continue  # bands of several runs would cover each other
            if curve.name == "reference r":
                series.append(replace(curve, run=k, quiet=k > 0))
                continue
            first = curve.panel == "position" and curve.name == "position q3"
            series.append(
                replace(
                    curve,
                    run=k,
                    color=run_color(k),
                    name=run.name if first else f"{run.name}: {curve.name}",
                    quiet=not first,
                    width=1.3,
                    dash="dot" if curve.name.startswith("true") else curve.dash,
                )
            )
    return series


def run_color(index: int) -> str:
    """Return the CSS variable of the color of a run."""
    return f"run-{index % len(RUNS) + 1}"


def plotted_runs(runs: Sequence[ComparedRun]) -> list[PlottedRun]:
    """Return what the plots need to know of the runs."""
    return [
        PlottedRun(
            run.name,
            float(run.recording.telemetry[0, 0]),
            float(run.recording.telemetry[-1, 0]),
            run.steps,
            run.summary.steps,
        )
        for run in runs
    ]


def runs_table(runs: Sequence[ComparedRun]) -> Table:
    """Return one row for each run."""
    degrees = float(np.rad2deg(1.0))
    rows = []
    for run in runs:
        summary = run.summary
        judged = [step for step in summary.steps if step.limit_cycle is not None]
        cycles, bias, residual = summary.limit_cycles, summary.worst_bias, summary.worst_residual
        errors = summary.estimate
        cells = (
            run.name,
            number(summary.duration_s, ".5g"),
            str(len(judged)),
            str(len(cycles)),
            number(cycles[0].t_start_s if cycles else None, ".6g"),
            number(abs(bias.bias_percent_of_amplitude or 0.0) if bias else None, ".3f"),
            number(residual.residual_peak_to_peak_m if residual else None, ".2f", 1e6),
            number(errors.stated_rms_error_rad, ".3f", degrees),
            number(errors.stated_max_error_rad, ".3f", degrees),
            number(errors.max_shortfall_rad, ".3f", degrees),
            number(errors.worst_lag_s, ".3f"),
            str(summary.lost_messages),
        )
        rows.append(Row(cells, alarm=bool(cycles)))
    return Table("runs", "Runs", RUN_COLUMNS, rows)


def all_steps_table(runs: Sequence[ComparedRun]) -> Table:
    """Return the steps of all runs, those that are compared one below the other."""
    rows = []
    for k in range(max((len(run.summary.steps) for run in runs), default=0)):
        for run in runs:
            if k < len(run.summary.steps):
                step = run.summary.steps[k]
                cells = (run.name, *step_cells(k + 1, step))
                rows.append(Row(cells, alarm=bool(step.limit_cycle), step=k + 1))
    return Table(
        "steps",
        "Steps",
        (Column("run", text=True), *STEP_COLUMNS),
        rows,
        empty="No reference holds during the telemetry of any run.",
    )
