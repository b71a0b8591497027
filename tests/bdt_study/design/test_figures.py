"""The figure of a design: what its panels show."""

import math

import numpy as np
import pytest

from bdt_analysis.figures.figure_style import write_png
from bdt_controller.pid import PidGains
from bdt_plant.plant import PlantModel
from bdt_study.design.figures import design_figure
from bdt_study.design.linear_model import loop_transfer, sampled_loop_transfer
from bdt_study.design.loop_margins import loop_margins
from bdt_study.design.pid_design import PidDesign

MODEL = PlantModel()
GAINS = PidGains(3080.0, 30800.0, -308.4, 0.074)


@pytest.fixture(scope="module")
def figure():
    margins = loop_margins(loop_transfer(MODEL, GAINS))
    sampled = loop_margins(sampled_loop_transfer(MODEL, GAINS, 500.0))
    return design_figure(MODEL, PidDesign(GAINS, margins, sampled, 500.0))


def panel(figure, letter):
    return next(axes for axes in figure.axes if axes.get_title(loc="left").startswith(letter))


def test_it_becomes_a_picture(figure, tmp_path):
    write_png(figure, tmp_path / "design.png", 40)
    assert (tmp_path / "design.png").stat().st_size > 5000


def test_each_phase_margin_reaches_from_the_curve_to_180_degrees(figure):
    bars = [line.get_ydata() for line in panel(figure, "(b)").get_lines() if line.get_lw() == 2.2]
    assert [bar[0] for bar in bars] == pytest.approx([-180.0] * 3, abs=0.05)
    assert bars[0][1] == pytest.approx(-180 + 16.75, abs=0.1)


def test_the_circle_around_minus_one_touches_the_nyquist_curve(figure):
    axes = panel(figure, "(c)")
    curve = next(line for line in axes.get_lines() if line.get_label() == "L(jω)")
    closest = np.hypot(curve.get_xdata() + 1, curve.get_ydata()).min()
    circle = axes.patches[0].get_xy()
    radius = np.hypot(circle[:, 0] + 1, circle[:, 1])
    assert radius == pytest.approx(closest, rel=2e-3)


def test_the_step_response_ends_at_the_reference(figure):
    curves = {line.get_label(): line for line in panel(figure, "(e)").get_lines()}
    for name in ("continuous", "sampled at 500 Hz"):
        times, values = curves[name].get_data()
        assert values[-1] == pytest.approx(1.0, abs=5e-3)
        assert math.isclose(times[-1], 4.0)
