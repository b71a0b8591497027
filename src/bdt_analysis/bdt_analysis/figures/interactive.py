"""Everything that the interactive part of a page embeds: library, curves, steps."""

from dataclasses import asdict, dataclass, fields
from typing import Any

from bdt_analysis.figures.curves import Panel, Series
from bdt_analysis.figures.embedding import packed_arrays, packed_text
from bdt_analysis.metrics.reference_steps import ReferenceStep
from bdt_analysis.metrics.step_analysis import StepSummary


@dataclass(frozen=True)
class PlottedRun:
    """One run of a page.

    Attributes
    ----------
    name : str
        What the page calls it.
    begin, end : float
        First and last time of the telemetry [s].
    steps : list of ReferenceStep
        Its steps.
    results : tuple of StepSummary
        What was found in each.
    marks : tuple of float
        Moments that somebody has marked [s].
    """

    name: str
    begin: float
    end: float
    steps: list[ReferenceStep]
    results: tuple[StepSummary, ...]
    marks: tuple[float, ...] = ()


def interactive_part(
    panels: list[Panel], series: list[Series], runs: list[PlottedRun], time_label: str
) -> dict[str, Any] | None:
    """Return the values that the template ``interactive.html`` needs; None without plotly.

    Times are held relative to the earliest one, so that 32-bit floats resolve them.

    Parameters
    ----------
    panels : list of Panel
        Plots from top to bottom.
    series : list of Series
        Their curves.
    runs : list of PlottedRun
        The runs, in the order of the indices in `series`.
    time_label : str
        Title of the time axis.
    """
    library = plotly_library()
    if library is None:
        return None
    origin = min(run.begin for run in runs)
    arrays = [array for item in series for array in (item.time - origin, item.value)]
    return {
        "plotly": packed_text(library),
        "signals": packed_text(packed_arrays(arrays)),
        "description": {
            "time_label": time_label,
            "origin": origin,
            "panels": [asdict(panel) for panel in panels],
            "series": [_description(item) for item in series],
            "runs": [_run_description(run) for run in runs],
        },
    }


def plotly_library() -> bytes | None:
    """Return the library that draws in the browser; None where plotly is not installed."""
    try:
        # No rosdep key is known for it: a ROS machine without it gets a report without it.
        from plotly.offline import get_plotlyjs  # noqa: PLC0415
    except ModuleNotFoundError:
        return None
    text: str = get_plotlyjs()
    return text.encode()


def _description(series: Series) -> dict[str, Any]:
    kept = [field.name for field in fields(series) if field.name not in {"time", "value"}]
    return {"points": int(series.time.size)} | {name: getattr(series, name) for name in kept}


def _run_description(run: PlottedRun) -> dict[str, Any]:
    return {
        "name": run.name,
        "begin": run.begin,
        "end": run.end,
        "marks": run.marks,
        "steps": [
            {
                "begin": max(step.t_start, run.begin),
                "end": step.t_end,
                "window": step.window,
                "reference": 1e3 * step.reference,
                "limit_cycle": bool(result.limit_cycle),
                "residual": result.residual_peak_to_peak_m,
            }
            for step, result in zip(run.steps, run.results, strict=True)
        ],
    }
