"""Figures of a calibration: residual in time and frequency, correlations."""

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.signal import welch

from bdt_analysis.figures import figure_style as style
from bdt_analysis.figures.decimation import envelope, hole_length
from bdt_analysis.figures.run_figures import COLUMNS
from bdt_study.calibration.calibrate import Calibration
from bdt_study.calibration.prior_knowledge import CALIBRATED_EFFECTS
from bdt_study.calibration.validation import Residual
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.model_factors import FACTORS

FloatArray = NDArray[np.float64]

SEGMENT = 2.0
"""Length of the pieces whose spectra are averaged [s]."""
HIGHEST = 200.0
"""Highest frequency that is shown [Hz]."""


def residual_figure(result: Calibration) -> Figure:
    """Return position and residuals over time, those of the validation beside those of the fit."""
    fit, validation = result.residual, result.validation
    with style.house_style():
        figure = style.new_figure(9.6, 5.4)
        position, residual = figure.subplots(2, 1, sharex=True, height_ratios=(1, 2))
        position.plot(*_line(result, fit, 1e3 * fit.position), color=style.POSITION)
        position.set_ylabel("$q_3$ [mm]")
        residual.plot(
            *_line(result, fit, 1e6 * fit.residual), color=style.ESTIMATE, label="fit to all"
        )
        residual.plot(
            *_line(result, validation, 1e6 * validation.residual),
            color=style.DEAD_ZONE,
            alpha=0.7,
            label="second half, machine of the first",
        )
        residual.set_ylabel("residual [µm]")
        residual.set_xlabel("time [s]")
        style.outside_legend(residual, 2)
        style.fix_layout(figure)
    return figure


def spectrum_figure(result: Calibration) -> Figure:
    """Return the amplitude spectral densities of the residuals and of the motion."""
    rate = result.data.sampling_rate
    with style.house_style():
        figure = style.new_figure(9.6, 3.6)
        axes = figure.subplots()
        curves: tuple[tuple[str, str, FloatArray], ...] = (
            ("$q_3$", style.POSITION, result.residual.position),
            ("residual of the fit", style.ESTIMATE, result.residual.residual),
            ("residual of the validation", style.DEAD_ZONE, result.validation.residual),
        )
        for label, color, values in curves:
            length = min(round(SEGMENT * rate), values.size)
            frequency, power = welch(values, rate, nperseg=length, detrend="linear")
            shown = (frequency > 0.0) & (frequency <= HIGHEST)
            axes.loglog(frequency[shown], np.sqrt(power[shown]), color=color, label=label)
        axes.set_xlabel("frequency [Hz]")
        axes.set_ylabel("density [m/√Hz]")
        style.outside_legend(axes, 3)
        style.fix_layout(figure)
    return figure


def correlation_table(result: Calibration) -> tuple[list[str], list[list[str]]]:
    """Return names, and the correlations of what was fitted as texts."""
    fitted = (*FACTORS, *CALIBRATED_EFFECTS, *result.found.joined)
    all_names = (*FACTORS, *EFFECTS)
    places = [all_names.index(name) for name in fitted]
    covariance = result.found.fit.machine.covariance[np.ix_(places, places)]
    scale = 1.0 / np.sqrt(np.diag(covariance))
    correlations = covariance * np.outer(scale, scale)
    names = [name.replace("_", " ") for name in fitted]
    return names, [[f"{value:+.2f}" for value in row] for row in correlations.tolist()]


def _line(
    result: Calibration, residual: Residual, values: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the points of a line over the times of a residual, with holes where data have them."""
    sample_time = 1.0 / result.data.sampling_rate
    return envelope(residual.times, values, COLUMNS, hole_length(sample_time))
