"""Figure 2: the backlash model under an amplitude-modulated sine, and its lost motion."""

import math
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bdt_analysis.figures import figure_style as style
from bdt_plant.lead_screw import play
from bdt_study.reproduction.claims import Claim

FloatArray = NDArray[np.float64]

GAP = math.radians(40.0)
"""Gap of figure 2 [rad]."""

DURATION = 10.0
"""Shown time [s]; the paper does not say."""

SAMPLE_TIME = 2e-4
"""Sample time [s]."""


class BacklashResponse(NamedTuple):
    """Motor and screw under the input of figure 2.

    Attributes
    ----------
    t : ndarray, shape (n,)
        Time [s].
    theta_m, theta_d : ndarray, shape (n,)
        Angles of motor and lead screw [rad].
    """

    t: FloatArray
    theta_m: FloatArray
    theta_d: FloatArray


def backlash_response() -> BacklashResponse:
    """Return the response of eq. 6 to theta_m = (1 + t/10) sin(2 pi t)."""
    t = np.linspace(0.0, DURATION, round(DURATION / SAMPLE_TIME) + 1)
    theta_m: FloatArray = (1.0 + t / 10.0) * np.sin(2 * math.pi * t)
    screw = 0.0
    theta_d = np.array([screw := play(screw, angle, GAP) for angle in theta_m.tolist()])
    return BacklashResponse(t, theta_m, theta_d)


def lost_motions(response: BacklashResponse) -> FloatArray:
    """Return how much further the motor stands at each forward than at the next backward pass.

    The passes are those of the screw through zero, so the result is the width of the loops of
    figure 2(b) [rad], read off the curves without knowing the gap.
    """
    before, after = response.theta_d[:-1], response.theta_d[1:]
    crossed = np.flatnonzero((before < 0) != (after < 0))
    fraction = before[crossed] / (before[crossed] - after[crossed])
    angles = response.theta_m[crossed]
    angles = angles + fraction * (response.theta_m[crossed + 1] - angles)
    forward = after[crossed] > before[crossed]
    count = min(int(forward.sum()), int((~forward).sum()))
    widths: FloatArray = angles[forward][:count] - angles[~forward][:count]
    return widths


def lost_motion_equals_gap(response: BacklashResponse) -> Claim:
    """Figure 2: the lost motion is the gap at every amplitude."""
    widths = np.rad2deg(lost_motions(response))
    farthest = float(widths[np.argmax(np.abs(widths - math.degrees(GAP)))])
    return Claim(
        "fig2_lost_motion_equals_gap",
        "The lost motion between motor and lead screw is the gap of 40 degrees.",
        farthest,
        "deg",
        abs(farthest - math.degrees(GAP)) < 0.01,
        f"width of the loops of figure 2(b), the one of {widths.size} farthest from 40°; "
        "within 0.01°",
    )


def figure_2(response: BacklashResponse) -> Figure:
    """Return figure 2: (a) both angles over time, (b) one against the other."""
    motor, screw = np.rad2deg(response.theta_m), np.rad2deg(response.theta_d)
    with style.house_style():
        figure = style.new_figure(9.6, 4.0)
        over_time, loops = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
        over_time.plot(response.t, motor, color=style.INK, ls="--", label="motor $θ_m$")
        over_time.plot(response.t, screw, color=style.POSITION, lw=1.6, label="lead screw $θ_d$")
        over_time.set_xlabel("time t [s]")
        over_time.set_ylabel("angle [deg]")
        over_time.set_xlim(0.0, DURATION)
        over_time.set_title("(a)", loc="left", fontweight="bold")
        style.outside_legend(over_time, 2)
        loops.plot(motor, screw, color=style.POSITION, lw=0.9)
        loops.annotate(
            "",
            (math.degrees(GAP) / 2, 0.0),
            (-math.degrees(GAP) / 2, 0.0),
            arrowprops={"arrowstyle": "<->", "color": style.ALARM_INK, "lw": 1.4},
        )
        loops.text(30.0, -8.0, "$θ_b$ = 40°", color=style.ALARM_INK)
        loops.set_xlabel("motor $θ_m$ [deg]")
        loops.set_ylabel("lead screw $θ_d$ [deg]")
        loops.set_title("(b)", loc="left", fontweight="bold")
        style.fix_layout(figure)
    return figure
