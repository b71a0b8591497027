"""Figure 6: the run of figure 4, post-processed."""

import math
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bdt_analysis.figures import figure_style as style
from bdt_analysis.figures.decimation import envelope
from bdt_analysis.figures.run_figures import COLUMNS
from bdt_study.reproduction.claims import Claim
from bdt_study.reproduction.experiments import PaperRuns
from bdt_twin.angle_observer import AngleObserver

FloatArray = NDArray[np.float64]

BLOCK = 0.1
"""Length of the intervals that count as rest or motion [s]."""

STILL = 1e-6
"""Peak to peak of q3 in an interval of rest [m]."""

LARGEST_AT_REST = 0.05
"""Difference of the angles at rest up to which they match [deg]; half of the rounding l."""


class ScrewAngle(NamedTuple):
    """The screw's angle as eq. 11 estimates it.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Time [s].
    error : ndarray, shape (n,)
        Estimated minus true theta_d at the same time [rad].
    at_rest : float
        Largest size of the error while the lead screw stands and q3 is still [rad].
    moving : float
        Largest size of the error while the lead screw turns [rad].
    """

    t: FloatArray
    error: FloatArray
    at_rest: float
    moving: float


def screw_angle(runs: PaperRuns) -> ScrewAngle:
    """Return the estimated angle of the lead screw (eq. 11) beside the true one."""
    loop, scenario = runs.fixed.loop, runs.choices.scenario()
    rate, delay = scenario.sampling.sampling_rate, runs.choices.settings().delay
    observer = AngleObserver(scenario.model, 1.0 / rate, delay)
    estimated = observer.update(loop.u, loop.q3).theta_d[delay:]
    error = estimated - loop.theta_d[:-delay]
    block = round(BLOCK * rate)
    blocks = error.size // block
    whole = slice(0, blocks * block)
    largest = np.abs(error[whole]).reshape(blocks, block).max(axis=1)
    turned = np.ptp(loop.theta_d[whole].reshape(blocks, block), axis=1)
    travel = np.ptp(loop.q3[whole].reshape(blocks, block), axis=1)
    rest = (turned == 0.0) & (travel < STILL)
    return ScrewAngle(
        loop.t[:-delay],
        error,
        float(largest[rest].max(initial=0.0)) if rest.any() else math.nan,
        float(largest[turned > 0.0].max(initial=0.0)),
    )


def constant_input_matches(angle: ScrewAngle) -> Claim:
    """Figure 6: no difference at rest."""
    error = math.degrees(angle.at_rest)
    return Claim(
        "fig6_constant_input_matches",
        "When the input to the inverse system is constant, the estimated angle of the lead screw "
        "matches the measured one.",
        error,
        "deg",
        error < LARGEST_AT_REST,
        "largest difference while the screw stands and q3 moves less than 1 µm in 0.1 s; "
        "below 0.05°",
    )


def moving_input_differs(angle: ScrewAngle) -> Claim:
    """Figure 6: a difference while the screw turns."""
    error = math.degrees(angle.moving)
    return Claim(
        "fig6_moving_input_differs",
        "The actual and estimated angles differ whenever the lead screw turns.",
        error,
        "deg",
        error > math.degrees(angle.at_rest),
        "largest difference while the screw turns; larger than at rest",
    )


def figure_6(runs: PaperRuns, angle: ScrewAngle) -> Figure:
    """Return figure 6: (a) command and output, (b) gaps, and the error of theta_d."""
    t, voltage, q3 = runs.fixed.signals.telemetry.T
    truth = runs.fixed.signals.truth
    with style.house_style():
        figure = style.new_figure(9.6, 8.4)
        command, output, gap, error = figure.subplots(
            4, 1, sharex=True, height_ratios=(0.8, 0.8, 1.2, 0.7)
        )
        command.plot(*envelope(t, voltage, COLUMNS), color=style.INK, lw=0.9)
        command.set_ylabel("command u [V]")
        command.set_title("(a)", loc="left", fontweight="bold")
        output.plot(*envelope(t, 1e3 * q3, COLUMNS), color=style.POSITION)
        output.set_ylabel("output $q_3$ [mm]")
        if truth is not None:
            gap.plot(
                truth[::50, 0],
                np.rad2deg(truth[::50, 3]),
                color=style.INK,
                lw=2.4,
                alpha=0.55,
                label="actual gap $θ_b$",
            )
        gap.plot(
            runs.post_processed[:, 0],
            np.rad2deg(runs.post_processed[:, 1]),
            ls="",
            marker="o",
            ms=3.2,
            mfc="none",
            color=style.ESTIMATE,
            label="estimated",
        )
        gap.set_ylabel("gap [deg]")
        gap.set_title("(b)", loc="left", fontweight="bold")
        style.outside_legend(gap, 2)
        error.plot(*envelope(angle.t, np.rad2deg(angle.error), COLUMNS), color=style.INK, lw=0.9)
        error.set_ylabel("$\\hat θ_d − θ_d$ [deg]")  # noqa: RUF001 - a minus sign
        error.set_title("(c)", loc="left", fontweight="bold")
        error.set_xlabel("time t [s]")
        error.set_xlim(0.0, runs.choices.duration)
        figure.align_ylabels([command, output, gap, error])
        style.fix_layout(figure)
    return figure
