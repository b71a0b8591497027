"""Figure of the limit cycle: predicted and simulated, over the gap and over the stiffness."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bdt_analysis.figures import figure_style as style
from bdt_plant.plant import PlantModel
from bdt_plant.structure import StructureParameters
from bdt_study.design.linear_model import structure_model
from bdt_study.limit_cycles.comparison import METHODS, LimitCycleComparison
from bdt_study.limit_cycles.harmonic_balance import LimitCycle

FloatArray = NDArray[np.float64]

_LOOKS: dict[str, dict[str, Any]] = {
    "describing_function": {"color": style.DEAD_ZONE, "ls": (0, (5, 2)), "marker": ""},
    "harmonic_balance": {"color": style.POSITION, "ls": "-", "marker": ""},
    "simulation": {"color": style.INK, "ls": "", "marker": "o", "mfc": style.PAPER, "ms": 5},
}


def limit_cycle_figure(
    model: PlantModel,
    over_gap: Sequence[LimitCycleComparison],
    over_stiffness: Sequence[LimitCycleComparison],
) -> Figure:
    """Return amplitude and frequency of the limit cycle over the gap and over the first mode.

    Parameters
    ----------
    model : PlantModel
        The mechanism of `over_gap`.
    over_gap : sequence of LimitCycleComparison
        From :func:`bdt_study.limit_cycles.comparison.compare_over_gap`.
    over_stiffness : sequence of LimitCycleComparison
        From :func:`bdt_study.limit_cycles.comparison.compare_over_stiffness`.
    """
    gaps = np.rad2deg([each.gap for each in over_gap])
    modes = np.array([_first_mode(model.structure, each.stiffness) for each in over_stiffness])
    with style.house_style():
        figure = style.new_figure(9.6, 6.4)
        (size, growth), (pitch, change) = figure.subplots(2, 2, sharex="col")
        _draw(size, gaps, over_gap, lambda cycle: 1e6 * cycle.peak_to_peak)
        _draw(pitch, gaps, over_gap, lambda cycle: cycle.frequency)
        _draw(growth, modes, over_stiffness, lambda cycle: 1e6 * cycle.peak_to_peak)
        _draw(change, modes, over_stiffness, lambda cycle: cycle.frequency)
        size.set_ylabel("$q_3$, peak to peak [µm]")
        pitch.set_ylabel("frequency [rad/s]")
        pitch.set_xlabel("gap $θ_b$ [deg]")
        change.set_xlabel("first mode of the structure [rad/s]")
        size.set_ylim(bottom=0.0)
        size.set_xlim(left=0.0)
        growth.set_ylim(bottom=0.0)
        change.set_xscale("log")
        ticks = [25, 30, 40, 60, 100, 150, 250]
        change.set_xticks(ticks, [str(tick) for tick in ticks])
        change.set_xticks([], minor=True)
        for axes in (pitch, change):
            low, high = _range(over_gap, over_stiffness)
            axes.set_ylim(low, high)
        _mark_resonance(model, over_gap, growth, change)
        size.set_title("(a) mechanism of table 1, over the gap", loc="left")
        degrees = np.rad2deg(over_stiffness[0].gap) if over_stiffness else 0.0
        growth.set_title(f"(b) stiffer and softer beams, gap {degrees:.3g}°", loc="left")
        size.legend(loc="upper left")
        figure.align_ylabels([size, pitch])
        style.fix_layout(figure)
    return figure


def _draw(
    axes: Axes,
    places: FloatArray,
    comparisons: Sequence[LimitCycleComparison],
    value: Callable[[LimitCycle], float],
) -> None:
    for method in METHODS:
        cycles: list[LimitCycle | None] = [getattr(each, method) for each in comparisons]
        values = [np.nan if cycle is None else value(cycle) for cycle in cycles]
        axes.plot(places, values, label=method.replace("_", " "), **_LOOKS[method])


def _mark_resonance(
    model: PlantModel, over_gap: Sequence[LimitCycleComparison], upper: Axes, lower: Axes
) -> None:
    """Mark where the third harmonic meets the first mode, and the mechanism of table 1."""
    simulated = next((each.simulation for each in over_gap if each.simulation), None)
    if simulated is None:
        return
    mode = _first_mode(model.structure, model.structure.stiffness)
    for axes in (upper, lower):
        axes.axvline(mode, color=style.FAINT, ls=":", lw=1.2, zorder=1.5)
    upper.annotate(
        f"table 1: mode {mode:.1f} rad/s\n≈ 3 · {simulated.frequency:.2f} rad/s",
        (mode, 0.05),
        xycoords=("data", "axes fraction"),
        xytext=(7, 0),
        textcoords="offset points",
        fontsize=9,
    )


def _first_mode(structure: StructureParameters, stiffness: float) -> float:
    """Return the natural frequency of the first mode [rad/s]; it goes with the root of k."""
    own = float(np.min(np.abs(structure_model(structure).poles())))
    return own * float(np.sqrt(stiffness / structure.stiffness))


def _range(*groups: Sequence[LimitCycleComparison]) -> tuple[float, float]:
    """Return the common limits of the two axes of frequency."""
    found = [
        cycle.frequency
        for comparisons in groups
        for each in comparisons
        for method in METHODS
        if (cycle := getattr(each, method)) is not None
    ]
    if not found:
        return 0.0, 1.0
    room = 0.1 * (max(found) - min(found)) + 0.1
    return min(found) - room, max(found) + room
