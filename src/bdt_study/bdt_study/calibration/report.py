"""The page of ``bdt calibrate``."""

import math

from bdt_analysis.figures.figure_style import svg_text
from bdt_analysis.pages.rendering import render_page
from bdt_study.calibration.calibrate import Calibration
from bdt_study.calibration.constant import GAP
from bdt_study.calibration.constant_rows import constant_rows, hints
from bdt_study.calibration.figures import correlation_table, residual_figure, spectrum_figure


def render_report(result: Calibration, source: str) -> str:
    """Return the page as text.

    Parameters
    ----------
    result : Calibration
        What was found.
    source : str
        Name of the bag.
    """
    names, correlations = correlation_table(result)
    data = result.data
    fit = result.found.fit
    return render_page(
        "report.html",
        folder="bdt_study.calibration",
        source=source,
        begin=f"{data.stretches[0].first / data.sampling_rate:.2f}",
        duration=f"{sum(each.voltage.size for each in data.stretches) / data.sampling_rate:.1f}",
        gap=f"{math.degrees(result.gap):.3f}",
        gap_uncertainty=f"{math.degrees(result.gap_uncertainty):.2g}",
        gap_time=f"{result.gap_time:.2f}",
        residual=f"{1e6 * result.residual.rms:.3g}",
        validation=f"{1e6 * result.validation.rms:.3g}",
        gap_is_told=result.constants[GAP].determined,
        unexplained=result.unexplained,
        noise=f"{1e6 * fit.levels.reading:.3g}",
        pushed=int(fit.pushed.sum()),
        constants=constant_rows(result),
        hints=hints(result),
        names=names,
        correlations=list(zip(names, correlations, strict=True)),
        residual_figure=svg_text(residual_figure(result), "residual"),
        spectrum_figure=svg_text(spectrum_figure(result), "spectrum"),
    )
