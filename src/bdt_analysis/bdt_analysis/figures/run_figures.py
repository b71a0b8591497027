"""The figures of a report, laid out like figures 3, 4, 6(b) and 7 of the paper."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bdt_analysis.figures import figure_style as style
from bdt_analysis.figures.decimation import envelope, hole_length
from bdt_analysis.metrics.lead_screw_pitch import lead_screw_pitch
from bdt_analysis.metrics.reference_steps import ReferenceStep
from bdt_analysis.metrics.step_analysis import StepSummary
from bdt_analysis.re_estimation.re_estimation import ReEstimation
from bdt_bags.run_signals import RunSignals

FloatArray = NDArray[np.float64]

COLUMNS = 1100
"""Pixel columns of a full-width axes."""

MOST_PANELS = 24
"""Number of steps that the figure of residuals shows."""


def overview_figure(
    run: RunSignals,
    steps: list[ReferenceStep],
    results: tuple[StepSummary, ...],
    re_estimation: ReEstimation | None = None,
) -> Figure:
    """Return reference and position, motor voltage, and gap with estimate and dead zone over time.

    Parameters
    ----------
    run : RunSignals
        The run.
    steps : list of ReferenceStep
        Its steps.
    results : tuple of StepSummary
        What was found in each; steps with a limit cycle are shaded.
    re_estimation : ReEstimation, optional
        What an estimator made of the telemetry.
    """
    with style.house_style():
        figure = style.new_figure(9.6, 7.6)
        grid = figure.subplots(3, 1, sharex=True, height_ratios=(1.15, 1.0, 1.15))
        position, voltage, gap = grid.tolist()
        _draw_position(position, run, steps)
        _draw_voltage(voltage, run)
        _draw_gap(gap, run, re_estimation)
        for axes in (position, voltage, gap):
            _shade_limit_cycles(axes, steps, results, label=axes is position)
        style.outside_legend(position, 3)
        begin, end = run.telemetry[0, 0], run.telemetry[-1, 0]
        gap.set_xlim(begin, end + run.sample_time)
        gap.set_xlabel(time_label(run))
        figure.align_ylabels([position, voltage, gap])
        style.fix_layout(figure)
    return figure


def residual_figure(
    run: RunSignals, steps: list[ReferenceStep], results: tuple[StepSummary, ...]
) -> Figure | None:
    """Return the residual q3 - r of each step, enlarged to what is left at its end.

    All panels have the same scale, so that the growth from step to step shows. Of more than 24
    steps those with the largest residual at the end are shown. None if no step can be judged.

    Parameters
    ----------
    run, steps, results
        See :func:`overview_figure`.
    """
    shown = shown_residuals(results)
    if not shown:
        return None
    limit = 1e6 * residual_limit(run, [steps[k] for k in shown])
    columns = min(4, len(shown))
    rows = -(-len(shown) // columns)
    with style.house_style():
        figure = style.new_figure(9.6, 0.8 + 1.75 * rows)
        panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for axes, k in zip(panels.flat, shown, strict=False):
            _draw_residual(axes, run, steps[k], results[k])
        for axes in panels.flat[len(shown) :]:
            axes.set_visible(False)
        panels[0, 0].set_ylim(-limit, limit)
        panels[0, 0].set_xlim(0.0, max(steps[k].length for k in shown))
        figure.supxlabel("time since the step [s]", fontsize=10)
        figure.supylabel("q3 − r [µm]", fontsize=10)  # noqa: RUF001 - a minus sign
        style.fix_layout(figure)
    return figure


def shown_residuals(results: tuple[StepSummary, ...]) -> list[int]:
    """Return the indices of the steps that :func:`residual_figure` shows, in the order of time."""
    sizes = {
        k: result.residual_peak_to_peak_m
        for k, result in enumerate(results)
        if result.residual_peak_to_peak_m is not None
    }
    return sorted(sorted(sizes, key=lambda k: sizes[k], reverse=True)[:MOST_PANELS])


def residual_limit(run: RunSignals, steps: list[ReferenceStep]) -> float:
    """Return the half height of a plot into which residuals at the ends and dead zones fit [m]."""
    time, _, q3 = run.telemetry.T
    largest = 0.0
    for step in steps:
        first, end = np.searchsorted(time, [step.t_end - step.window, step.t_end])
        largest = max(largest, float(np.max(np.abs(q3[first:end] - step.reference), initial=0.0)))
        tolerance = _dead_zone_within(run.dead_zones, step)[1]
        largest = max(largest, float(np.max(tolerance, initial=0.0)))
    return 1.2 * largest or 1e-6


def time_label(run: RunSignals) -> str:
    """Return the title of the time axis, with the origin of a clock that counts from 1970."""
    if run.time_origin:
        return f"time − {run.time_origin:.0f} s [s]"  # noqa: RUF001 - a minus sign
    return "time t [s]"


def _draw_position(axes: Axes, run: RunSignals, steps: list[ReferenceStep]) -> None:
    time, _, q3 = run.telemetry.T
    axes.plot(*_line(run, time, 1e3 * q3), color=style.POSITION, label="position $q_3$", lw=1.3)
    edges = np.array([[step.t_start, step.t_end] for step in steps]).ravel()
    levels = np.array([[step.reference, step.reference] for step in steps]).ravel()
    if len(steps):
        axes.plot(
            *envelope(edges, 1e3 * levels, COLUMNS),
            color=style.INK,
            ls=(0, (4, 2)),
            lw=1.0,
            label="reference r",
        )
    axes.set_ylabel("position [mm]")
    _letter(axes, "(a)")


def _draw_voltage(axes: Axes, run: RunSignals) -> None:
    time, voltage, _ = run.telemetry.T
    axes.plot(*_line(run, time, voltage), color=style.INK, lw=0.9)
    axes.set_ylabel("motor voltage u [V]")
    _letter(axes, "(b)")


def _draw_gap(axes: Axes, run: RunSignals, re_estimation: ReEstimation | None) -> None:
    re_estimates, name = np.empty((0, 2)), ""
    if re_estimation is not None:
        re_estimates = np.column_stack([re_estimation.estimates.time, re_estimation.estimates.gap])
        name = f"re-estimated ({re_estimation.summary.estimator})"
    end = run.telemetry[-1, 0]
    if run.truth is not None:
        gap = np.rad2deg(run.truth[:, 3])
        axes.plot(
            *envelope(run.truth[:, 0], gap, COLUMNS),
            color=style.INK,
            lw=2.4,
            alpha=0.55,
            label="true gap",
        )
    for rows, scale, color, dashes, label in (
        (run.estimates, 1.0, style.ESTIMATE, "-", "estimated gap"),
        (re_estimates, 1.0, style.RUNS[3], "-", name),
        (run.dead_zones, lead_screw_pitch(run), style.DEAD_ZONE, (0, (3, 1.5)), "dead zone ε/p"),
    ):
        if len(rows):
            time = np.append(rows[:, 0], max(end, rows[-1, 0]))
            angle = np.rad2deg(np.append(rows[:, 1], rows[-1, 1]) / scale)
            axes.plot(
                *envelope(time, angle, COLUMNS),
                color=color,
                ls=dashes,
                lw=1.2,
                drawstyle="steps-post",
                label=label,
            )
    micrometers = np.deg2rad(1.0) * lead_screw_pitch(run) * 1e6
    right = axes.secondary_yaxis(
        "right", functions=(lambda x: x * micrometers, lambda x: x / micrometers)
    )
    right.set_ylabel("dead zone ε [µm]")
    # A dead zone of zero lies on the axis: leave it room.
    highest = axes.get_ylim()[1]
    axes.set_ylim(-0.03 * highest, highest)
    axes.set_ylabel("gap [deg]")
    if axes.get_legend_handles_labels()[0]:
        style.outside_legend(axes, 3)
    _letter(axes, "(c)")


def _draw_residual(axes: Axes, run: RunSignals, step: ReferenceStep, result: StepSummary) -> None:
    time, _, q3 = run.telemetry.T
    first, end = np.searchsorted(time, [step.t_start, step.t_end])
    axes.axvspan(step.length - step.window, step.length, color=style.WINDOW, lw=0)
    edges, tolerance = _dead_zone_within(run.dead_zones, step)
    axes.fill_between(edges, -1e6 * tolerance, 1e6 * tolerance, step="post", color=style.BAND, lw=0)
    for sign in (-1e6, 1e6):
        axes.step(edges, sign * tolerance, where="post", color=style.DEAD_ZONE, lw=0.7, ls="--")
    residual = 1e6 * (q3[first:end] - step.reference)
    axes.plot(
        *_line(run, time[first:end] - step.t_start, residual, COLUMNS // 3),
        color=style.POSITION,
        lw=0.9,
    )
    alarm = bool(result.limit_cycle)
    if alarm:
        axes.set_facecolor(style.ALARM)
    axes.set_title(
        f"{step.t_start:.5g} s: r = {1e3 * step.reference:.3g} mm", loc="left", fontsize=9
    )
    axes.set_title(
        f"{1e6 * (result.residual_peak_to_peak_m or 0.0):.3g} µm",
        loc="right",
        fontsize=9,
        color=style.ALARM_INK if alarm else style.INK,
        fontweight="bold" if alarm else "normal",
    )


def _dead_zone_within(dead_zones: FloatArray, step: ReferenceStep) -> tuple[FloatArray, FloatArray]:
    """Return times since the beginning of a step [s] and the dead zone from then on [m]."""
    before = int(np.searchsorted(dead_zones[:, 0], step.t_start, side="right")) - 1
    rows = dead_zones[max(before, 0) :]
    rows = rows[rows[:, 0] < step.t_end]
    if not len(rows):
        return np.empty(0), np.empty(0)
    times = np.clip(np.append(rows[:, 0], step.t_end) - step.t_start, 0.0, step.length)
    return times, np.append(rows[:, 1], rows[-1, 1])


def _shade_limit_cycles(
    axes: Axes,
    steps: list[ReferenceStep],
    results: tuple[StepSummary, ...],
    *,
    label: bool,
) -> None:
    """Shade the steps with a limit cycle; neighbors become one interval."""
    intervals: list[list[float]] = []
    for step, result in zip(steps, results, strict=True):
        if not result.limit_cycle:
            continue
        if intervals and intervals[-1][1] == step.t_start:
            intervals[-1][1] = step.t_end
        else:
            intervals.append([step.t_start, step.t_end])
    for number, (begin, end) in enumerate(intervals):
        name = "limit cycle" if label and not number else None
        axes.axvspan(begin, end, facecolor=style.ALARM, lw=0, zorder=0.5, label=name)


def _line(
    run: RunSignals, time: FloatArray, value: FloatArray, columns: int = COLUMNS
) -> tuple[FloatArray, FloatArray]:
    return envelope(time, value, columns, hole_length(run.sample_time))


def _letter(axes: Axes, text: str) -> None:
    axes.set_title(text, loc="left", fontweight="bold", pad=4)
