"""What is left of each step in several runs, as a picture."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bdt_analysis.figures import figure_style as style
from bdt_analysis.metrics.compared_runs import ComparedRun

MARKERS = "osD^vP"
"""Shapes that tell runs apart without color."""


def comparison_figure(runs: Sequence[ComparedRun]) -> Figure:
    """Return residual and bias of the steps over the time at which they begin.

    A filled mark is a limit cycle.

    Parameters
    ----------
    runs : sequence of ComparedRun
        The runs.
    """
    with style.house_style():
        figure = style.new_figure(9.6, 3.8)
        left, right = figure.subplots(1, 2).tolist()
        for k, run in enumerate(runs):
            residuals = [_scaled(step.residual_peak_to_peak_m, 1e6) for step in run.summary.steps]
            biases = [_scaled(step.bias_percent_of_amplitude, 1.0) for step in run.summary.steps]
            _draw(left, run, k, residuals)
            _draw(right, run, k, biases)
        if any(len(line.get_xydata()) for line in left.lines):
            left.set_yscale("log")
        left.set_ylabel("residual, peak to peak [µm]")
        right.set_ylabel("bias [% of the amplitude]")
        for axes in (left, right):
            axes.set_xlabel("begin of the step [s]")
        style.outside_legend(left, 3)
        style.fix_layout(figure)
    return figure


def _draw(axes: Axes, run: ComparedRun, index: int, values: list[float | None]) -> None:
    color = style.RUNS[index % len(style.RUNS)]
    known = [
        (step, value)
        for step, value in zip(run.summary.steps, values, strict=True)
        if value is not None
    ]
    axes.plot(
        [step.t_start_s for step, _ in known],
        [value for _, value in known],
        color=color,
        lw=0.9,
        marker=MARKERS[index % len(MARKERS)],
        markersize=6,
        markerfacecolor=style.PAPER,
        label=run.name,
    )
    cycles = [(step, value) for step, value in known if step.limit_cycle]
    axes.plot(
        [step.t_start_s for step, _ in cycles],
        [value for _, value in cycles],
        color=color,
        ls="none",
        marker=MARKERS[index % len(MARKERS)],
        markersize=6,
    )


def _scaled(value: float | None, scale: float) -> float | None:
    return None if value is None else value * scale
