"""Bode, Nyquist and step response of a PID design in one figure."""

import math
from typing import Any

import numpy as np
from control import StateSpace, forced_response
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bdt_analysis.figures import figure_style as style
from bdt_plant.plant import PlantModel
from bdt_study.design.linear_model import (
    closed_loop,
    frequency_response,
    loop_transfer,
    sampled_loop_transfer,
)
from bdt_study.design.loop_margins import LoopMargins, characteristic_frequencies
from bdt_study.design.pid_design import PidDesign

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

LIMITS = (0.05, 20.0)
"""Ends of the frequency axes over the first crossover."""

CIRCLE = 2 * math.pi * np.arange(361) / 360

_LEAST: dict[str, Any] = {"color": style.FAINT, "ls": "-", "lw": 0.9}


def design_figure(model: PlantModel, design: PidDesign, duration: float = 4.0) -> Figure:
    """Return Bode diagram (a, b), Nyquist curve (c), sensitivities (d) and step response (e).

    Parameters
    ----------
    model : PlantModel
        Constants of the mechanism.
    design : PidDesign
        From :func:`bdt_study.design.pid_design.design_pid` for that mechanism.
    duration : float
        Length of the step response [s].
    """
    loop = loop_transfer(model, design.gains)
    margins = design.margins
    low, high = (limit * margins.first_crossover for limit in LIMITS)
    frequency = characteristic_frequencies(loop)
    frequency = frequency[(frequency > low) & (frequency < high)]
    response = frequency_response(loop, frequency)
    with style.house_style():
        figure = style.new_figure(10.2, 8.0)
        panels = figure.subplot_mosaic(
            [["size", "nyquist"], ["phase", "nyquist"], ["sensitivity", "step"]],
            height_ratios=(1.0, 1.0, 1.15),
        )
        _draw_magnitude(panels["size"], frequency, response, margins)
        _draw_phase(panels["phase"], frequency, response, margins)
        _draw_nyquist(panels["nyquist"], response, margins, loop)
        _draw_sensitivity(panels["sensitivity"], frequency, response, margins)
        _draw_step(panels["step"], model, design, duration)
        for name in ("size", "phase", "sensitivity"):
            panels[name].set_xscale("log")
            panels[name].set_xlim(low, high)
            panels[name].xaxis.set_major_formatter("{x:g}")
        for name in ("size", "phase"):
            panels[name].tick_params(labelbottom=False)
        panels["sensitivity"].set_xlabel("frequency [rad/s]")
        figure.align_ylabels([panels[name] for name in ("size", "phase", "sensitivity")])
        style.fix_layout(figure)
    return figure


def _draw_magnitude(
    axes: Axes, frequency: FloatArray, response: ComplexArray, margins: LoopMargins
) -> None:
    axes.axhline(0.0, **_LEAST)
    axes.plot(frequency, _decibels(response), color=style.POSITION, lw=1.5)
    places = [crossover.frequency for crossover in margins.crossovers]
    axes.plot(places, np.zeros(len(places)), **_points())
    axes.annotate(
        f"first crossover\n{margins.first_crossover:.3g} rad/s",
        (margins.first_crossover, 0.0),
        xytext=(-10, -8),
        textcoords="offset points",
        fontsize=9,
        ha="right",
        va="top",
    )
    axes.set_ylim(-60.0, None)
    axes.set_ylabel("|L| [dB]")
    axes.set_title("(a) loop $L = C_{PID}\\, p\\, G_1 G_2$, magnitude", loc="left")


def _draw_phase(
    axes: Axes, frequency: FloatArray, response: ComplexArray, margins: LoopMargins
) -> None:
    # Above -180 degrees at the first crossover, and continuous from there.
    phase = np.rad2deg(np.unwrap(np.angle(response)))
    first = margins.crossovers[0]
    wanted = math.degrees(first.phase_margin) - 180.0
    phase += 360.0 * round((wanted - np.interp(first.frequency, frequency, phase)) / 360.0)
    axes.axhline(-180.0, **_LEAST)
    axes.plot(frequency, phase, color=style.POSITION, lw=1.5)
    for crossover in margins.crossovers:
        at = float(np.interp(crossover.frequency, frequency, phase))
        margin = math.degrees(crossover.phase_margin)
        axes.plot([crossover.frequency] * 2, [at - margin, at], color=style.DEAD_ZONE, lw=2.2)
        axes.plot([crossover.frequency], [at], **_points())
        axes.annotate(
            f"{margin:+.1f}°".replace("-", "−"),  # noqa: RUF001
            (crossover.frequency, at),
            # Beside the curve, which falls: to the left of it below, to the right above.
            xytext=(9, 6) if margin > 0 else (-9, -5),
            textcoords="offset points",
            fontsize=9,
            ha="left" if margin > 0 else "right",
            va="center",
        )
    ticks = np.arange(180 * math.floor(phase.min() / 180), 1, 180)
    axes.set_yticks(ticks, [f"−{-tick:.0f}°" if tick else "0°" for tick in ticks])  # noqa: RUF001
    axes.set_ylim(phase.min() - 30.0, min(phase.max() + 60.0, 0.0))
    axes.set_ylabel("phase of L")
    smallest = math.degrees(margins.smallest_phase_margin)
    axes.set_title(f"(b) phase; smallest margin {smallest:.1f}°, over all crossovers", loc="left")


def _draw_nyquist(
    axes: Axes, response: ComplexArray, margins: LoopMargins, loop: StateSpace
) -> None:
    axes.plot(np.cos(CIRCLE), np.sin(CIRCLE), color=style.FAINT, lw=0.9, ls=(0, (4, 2)))
    radius = 1.0 / margins.maximum_sensitivity
    axes.fill(
        radius * np.cos(CIRCLE) - 1,
        radius * np.sin(CIRCLE),
        facecolor=style.BAND,
        edgecolor=style.DEAD_ZONE,
        lw=1.0,
        label=f"distance 1/$M_s$ = {radius:.2f} from −1 ($M_s$ = {1 / radius:.2f})",  # noqa: RUF001
    )
    axes.plot(response.real, response.imag, color=style.POSITION, lw=1.5, label="L(jω)")
    axes.plot(response.real, -response.imag, color=style.POSITION, lw=0.9, ls=":", label="L(−jω)")  # noqa: RUF001
    axes.plot([-1], [0], marker="P", ms=8, color=style.INK, ls="")
    places = np.array([crossover.frequency for crossover in margins.crossovers])
    points = frequency_response(loop, places)
    axes.plot(points.real, points.imag, **_points())
    for place, point in zip(places, points, strict=True):
        axes.annotate(
            f"{place:.1f} rad/s",
            (point.real, point.imag),
            # Off the real axis, where the curve passes -1.
            xytext=(9, -3) if point.real > 0 else (11, 9 if point.imag > 0 else -11),
            textcoords="offset points",
            fontsize=9,
            va="center",
        )
    reach = 1.15 * max(1.6, float(np.abs(response[_beyond(response)]).max(initial=0.0)))
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel("Re L")
    axes.set_ylabel("Im L")
    axes.legend(loc="upper left", fontsize=8.5)
    gain = 20 * math.log10(margins.gain_margin)
    axes.set_title(
        f"(c) Nyquist; gain margin {margins.gain_margin:.2f} ({gain:.1f} dB)", loc="left"
    )


def _draw_sensitivity(
    axes: Axes, frequency: FloatArray, response: ComplexArray, margins: LoopMargins
) -> None:
    axes.axhline(0.0, **_LEAST)
    level = -10 * math.log10(2.0)
    axes.axhline(level, color=style.FAINT, lw=0.9, ls=":")
    sensitivity = 1 / (1 + response)
    axes.plot(
        frequency, _decibels(response * sensitivity), color=style.POSITION, lw=1.5, label="|T|"
    )
    axes.plot(
        frequency,
        _decibels(sensitivity),
        color=style.DEAD_ZONE,
        lw=1.5,
        ls=(0, (5, 2)),
        label="|S|",
    )
    axes.plot([margins.bandwidth], [level], **_points())
    axes.annotate(
        f"|T| = −3 dB\nat {margins.bandwidth:.3g} rad/s",  # noqa: RUF001
        (margins.bandwidth, level),
        xytext=(24, -30),
        textcoords="offset points",
        fontsize=9,
        va="center",
        arrowprops={"arrowstyle": "-", "color": style.FAINT, "lw": 0.8},
    )
    axes.set_ylim(-40.0, 15.0)
    axes.set_ylabel("magnitude [dB]")
    axes.legend(loc="lower center")
    axes.set_title("(d) sensitivities S = 1/(1 + L) and T = L/(1 + L)", loc="left")


def _draw_step(axes: Axes, model: PlantModel, design: PidDesign, duration: float) -> None:
    times = np.arange(round(duration * design.control_rate) + 1) / design.control_rate
    continuous = closed_loop(loop_transfer(model, design.gains))
    sampled = closed_loop(sampled_loop_transfer(model, design.gains, design.control_rate))
    axes.axhline(1.0, color=style.INK, lw=1.0, ls=(0, (4, 2)), label="reference r")
    for system, color, dashes, width, label in (
        (continuous, style.POSITION, "-", 1.5, "continuous"),
        (sampled, style.DEAD_ZONE, ":", 1.8, f"sampled at {design.control_rate:g} Hz"),
    ):
        response = forced_response(system, times, np.ones_like(times)).outputs
        axes.plot(times, response, color=color, ls=dashes, lw=width, label=label)
    axes.set_xlim(0.0, duration)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("$q_3$ / step of r")
    axes.legend(loc="lower right")
    axes.set_title("(e) step response without backlash", loc="left")


def _points() -> dict[str, Any]:
    """Return the look of marked points: rings, which differ from lines in grey too."""
    return {"marker": "o", "ms": 5.5, "mfc": style.PAPER, "mec": style.INK, "ls": "", "zorder": 5}


def _decibels(values: ComplexArray) -> FloatArray:
    return np.asarray(20 * np.log10(np.abs(values)))


def _beyond(response: ComplexArray) -> NDArray[np.bool_]:
    """Tell which points lie after the first crossover: before it the curve comes from infinity."""
    return np.asarray(np.cumsum(np.abs(response) < 1) > 0)
