"""Errors of the estimates over the cases, as a figure."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from bdt_analysis.figures import figure_style as style
from bdt_study.evaluation.trial import Trial

SMALLEST, LARGEST = 1e-3, 1e3
"""Errors that are smaller or larger are drawn at these [deg]."""


def error_figure(trials: Mapping[tuple[str, str], Sequence[Trial]]) -> Figure:
    """Return the distribution of the errors of each case and estimator.

    Parameters
    ----------
    trials : mapping
        Trials for each (name of the case, estimator).

    Returns
    -------
    Figure
        A box from the lower to the upper quartile of the size of the error, whiskers to 5 % and
        95 %, the worst as a cross.
    """
    cases = list(dict.fromkeys(case for case, _ in trials))
    kinds = list(dict.fromkeys(kind for _, kind in trials))
    colors = (style.DEAD_ZONE, style.POSITION, style.ALARM_INK, style.FAINT)
    with style.house_style():
        figure = style.new_figure(9.6, 0.8 + 0.45 * len(cases) * max(len(kinds), 1) ** 0.5)
        axes = figure.subplots()
        width = 0.7 / len(kinds)
        for number, kind in enumerate(kinds):
            color = colors[number % len(colors)]
            for row, case in enumerate(cases):
                errors = np.concatenate([trial.errors for trial in trials[case, kind]])
                if not errors.size:
                    continue
                sizes = np.rad2deg(np.abs(errors)).clip(SMALLEST, LARGEST)
                place = row + (number - 0.5 * (len(kinds) - 1)) * width
                low, first, middle, third, high = np.percentile(sizes, [5, 25, 50, 75, 95])
                axes.plot([low, high], [place, place], color=color, lw=1.0)
                axes.barh(
                    place,
                    third - first,
                    left=first,
                    height=0.7 * width,
                    color=color,
                    alpha=0.55,
                    label=kind if row == 0 else None,
                )
                axes.plot([middle], [place], color=color, marker="|", ms=10)
                axes.plot([sizes.max()], [place], color=color, marker="x", ms=5)
        axes.set_xscale("log")
        axes.set_xlim(SMALLEST, 1.5 * LARGEST)
        axes.set_yticks(range(len(cases)), cases)
        axes.invert_yaxis()
        axes.set_xlabel(f"size of the error of the estimated gap [deg], {LARGEST:g} for more")
        axes.legend(loc="upper right")
        style.fix_layout(figure)
    return figure
