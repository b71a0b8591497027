"""The signals of a run as curves of the interactive plots, decimated without losing an extreme."""

from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bdt_analysis.figures.curves import Panel, Series
from bdt_analysis.figures.decimation import envelope, hole_length
from bdt_analysis.figures.run_figures import residual_limit
from bdt_analysis.metrics.lead_screw_pitch import lead_screw_pitch
from bdt_analysis.metrics.reference_steps import ReferenceStep
from bdt_analysis.re_estimation.re_estimation import ReEstimation
from bdt_bags.run_signals import RunSignals

FloatArray = NDArray[np.float64]

TIME_BINS = 60_000
"""Time bins of which a page holds first, smallest, largest and last sample: 2 ms of the
paper's 120 s, one control period. Half as many, or a quarter, when that is too many points."""

MOST_POINTS = 450_000
"""Points of all curves together that a page may hold: less than 2.5 MB of it, also for noise."""

FEWEST_TIME_BINS = 2_000
"""Time bins that are held in any case."""

COVERAGE = 2.0
"""Half width of the band around the estimate, in standard uncertainties: about 95 %."""

SAME_POSITION = 1e-9
"""Difference [m] up to which the true position is the measured one."""

RE_ESTIMATED = "run-4"
"""Color of what an estimator made of the telemetry again."""

TRUE_GAP, TRUE_Q3 = 3, 6
"""Columns of the truth."""


def panels(run: RunSignals, steps: list[ReferenceStep]) -> list[Panel]:
    """Return the plots of a run from top to bottom.

    The panel of the error begins at the scale of what is left at the end of a step.

    Parameters
    ----------
    run : RunSignals
        The run.
    steps : list of ReferenceStep
        Its steps.
    """
    judged = [step for step in steps if not step.cut]
    limit = 1e6 * residual_limit(run, judged)
    return [
        Panel("position", "position", "mm"),
        Panel("error", "error q3 − r", "µm", (-limit, limit)),  # noqa: RUF001 - a minus sign
        Panel("voltage", "voltage u", "V"),
        Panel("gap", "gap", "deg"),
    ]


def run_series(
    run: RunSignals,
    steps: list[ReferenceStep],
    most_points: int = MOST_POINTS,
    re_estimation: ReEstimation | None = None,
) -> list[Series]:
    """Return the curves of a run.

    Parameters
    ----------
    run : RunSignals
        The run.
    steps : list of ReferenceStep
        Its steps.
    most_points : int
        Number of points that all curves may have together.
    re_estimation : ReEstimation, optional
        What an estimator made of its telemetry.

    Returns
    -------
    list of Series
        In the order in which they are drawn. A curve without data is left out; the true position
        as well when the measured one is the same.
    """
    bins = TIME_BINS
    repeated = [] if re_estimation is None else _re_estimates(run, re_estimation)
    while True:
        series = [*_series(run, steps, _Decimation(bins)), *repeated]
        if sum(curve.time.size for curve in series) <= most_points or bins <= FEWEST_TIME_BINS:
            return series
        bins //= 2


def _series(run: RunSignals, steps: list[ReferenceStep], measured: "_Decimation") -> list[Series]:
    time, voltage, q3 = run.telemetry.T
    reference = _reference(steps, time)
    degrees = float(np.rad2deg(1.0))
    curves = [
        *_dead_zone_band(run),
        measured.series("position", "position q3", "position", time, 1e3 * q3),
        measured.series("error", "q3 − r", "position", time, 1e6 * (q3 - reference)),  # noqa: RUF001
        measured.series("voltage", "voltage u", "ink", time, voltage),
    ]
    if run.truth is not None:
        curves += _truth(run, run.truth, steps, measured)
    curves += [
        *_reference_levels(steps),
        *_uncertainty_band(run, run.estimates, run.uncertainties, "estimate", "estimate"),
        _held(run, run.estimates, degrees, panel="gap", name="estimated gap", color="estimate"),
        _held(
            run,
            run.dead_zones,
            degrees / lead_screw_pitch(run),
            panel="gap",
            name="dead zone ε/p",
            color="dead-zone",
            dash="dash",
        ),
    ]
    return [curve for curve in curves if curve.time.size]


class _Decimation:
    """Makes curves of samples, with the extremes of time bins."""

    def __init__(self, bins: int) -> None:
        self._bins = bins

    def series(
        self, panel: str, name: str, color: str, time: FloatArray, value: FloatArray
    ) -> Series:
        known = np.isfinite(value)
        time, value = time[known], value[known]
        if time.size < 2:
            return Series(panel=panel, name=name, color=color, time=time, value=value)
        hole = hole_length(float(np.median(np.diff(time))))
        times, values = envelope(time, value, self._bins, hole)
        whole = times.size >= time.size
        return Series(
            panel=panel,
            name=name,
            color=color,
            time=times,
            value=values,
            samples=time.size,
            bin_width=None if whole else float(time[-1] - time[0]) / self._bins,
        )


def _truth(
    run: RunSignals, truth: FloatArray, steps: list[ReferenceStep], decimation: _Decimation
) -> list[Series]:
    """Return the true gap, and the true position where the measured one differs."""
    time = truth[:, 0]
    gap = decimation.series("gap", "true gap", "faint", time, np.rad2deg(truth[:, TRUE_GAP]))
    curves = [replace(gap, width=3.0)]
    true_q3 = truth[:, TRUE_Q3]
    measured = np.interp(time, run.telemetry[:, 0], run.telemetry[:, 2])
    inside = (time >= run.telemetry[0, 0]) & (time <= run.telemetry[-1, 0])
    if (np.abs(true_q3 - measured)[inside] > SAME_POSITION).any():
        error = 1e6 * (true_q3 - _reference(steps, time))
        curves += [
            decimation.series("position", "true q3", "ink", time, 1e3 * true_q3),
            decimation.series("error", "true q3 − r", "ink", time, error),  # noqa: RUF001
        ]
    return curves


def _reference(steps: list[ReferenceStep], time: FloatArray) -> FloatArray:
    """Return the reference at each time [m]; NaN before the first step."""
    if not steps:
        return np.full(time.shape, np.nan)
    starts = np.array([step.t_start for step in steps])
    levels = np.array([step.reference for step in steps])
    # Stamps and sample times are rounded differently: a step begins with its own sample.
    index = np.searchsorted(starts, time + 1e-9, side="right") - 1
    return np.where(index >= 0, levels[index], np.nan)


def _reference_levels(steps: list[ReferenceStep]) -> list[Series]:
    if not steps:
        return []
    time = np.array([*(step.t_start for step in steps), steps[-1].t_end])
    level = np.array([*(step.reference for step in steps), steps[-1].reference])
    return [
        Series(
            panel="position",
            name="reference r",
            color="ink",
            time=time,
            value=1e3 * level,
            steps=True,
            dash="dash",
            samples=len(steps),
        )
    ]


def _held(
    run: RunSignals,
    rows: FloatArray,
    scale: float,
    *,
    panel: str,
    name: str,
    color: str,
    dash: Literal["solid", "dash", "dot"] = "solid",
    fill: bool = False,
    quiet: bool = False,
) -> Series:
    """Return a value that holds until the next one, the last one until the end of the run."""
    end = float(run.telemetry[-1, 0])
    if len(rows) and rows[-1, 0] < end:
        rows = np.vstack([rows[:, :2], [end, rows[-1, 1]]])
    return Series(
        panel=panel,
        name=name,
        color=color,
        time=rows[:, 0],
        value=scale * rows[:, 1],
        steps=True,
        dash=dash,
        fill=fill,
        quiet=quiet,
        samples=len(rows),
    )


def _re_estimates(run: RunSignals, re_estimation: ReEstimation) -> list[Series]:
    """Return what the estimator said of the recorded telemetry, and how sure it was."""
    stated, name = re_estimation.estimates, f"re-estimated ({re_estimation.summary.estimator})"
    if not len(stated.time):
        return []
    rows = np.column_stack([stated.time, stated.gap])
    uncertainties = np.column_stack([stated.time, stated.uncertainty])
    return [
        *_uncertainty_band(run, rows, uncertainties, name, RE_ESTIMATED),
        _held(run, rows, float(np.rad2deg(1.0)), panel="gap", name=name, color=RE_ESTIMATED),
    ]


def _uncertainty_band(
    run: RunSignals, estimates: FloatArray, uncertainties: FloatArray, whose: str, color: str
) -> list[Series]:
    """Return lower and upper edge of an estimate's uncertainty; no band where it is not finite."""
    in_force = np.searchsorted(estimates[:, 0], uncertainties[:, 0], side="right") - 1
    known = (in_force >= 0) & np.isfinite(uncertainties[:, 1])
    if not known.any():
        return []
    rows, gaps = uncertainties[known], estimates[in_force[known], 1]
    degrees, name = float(np.rad2deg(1.0)), f"{whose} ± {COVERAGE:g} standard uncertainties"
    edges = []
    for sign in (-COVERAGE, COVERAGE):
        edge = np.stack([rows[:, 0], gaps + sign * rows[:, 1]], axis=1)
        band = _held(run, edge, degrees, panel="gap", name=name, color=color)
        edges.append(replace(band, width=0.0, quiet=sign < 0, fill=sign > 0))
    return edges


def _dead_zone_band(run: RunSignals) -> list[Series]:
    """Return lower and upper edge of the dead zone around the reference."""
    rows = run.dead_zones
    if not len(rows) or not rows[:, 1].any():
        return []
    name, color = "dead zone ±ε", "dead-zone"
    lower = _held(run, rows, -1e6, panel="error", name=name, color=color, dash="dash", quiet=True)
    upper = _held(run, rows, 1e6, panel="error", name=name, color=color, dash="dash", fill=True)
    return [lower, upper]
