"""Figures are laid out once, whatever the user's own settings of matplotlib are."""

import matplotlib as mpl
import pytest
from matplotlib.figure import Figure

from bdt_analysis.figures import figure_style as style


@pytest.fixture
def drawings(monkeypatch):
    """Return a list that grows with each time that a figure is drawn."""
    drawn, draw = [], Figure.draw
    monkeypatch.setattr(Figure, "draw", lambda *given: drawn.append(1) or draw(*given))
    return drawn


@pytest.mark.parametrize("setting", ["figure.autolayout", "figure.constrained_layout.use"])
@pytest.mark.parametrize("write", [style.write_png, style.write_svg])
def test_a_figure_that_is_laid_out_is_drawn_once_for_a_file(drawings, tmp_path, write, setting):
    with mpl.rc_context({setting: True}):
        figure = style.new_figure(4.0, 3.0)
        axes = figure.subplots()
        axes.set_ylabel("a long label\nof two lines")
        before = axes.get_position().bounds
        style.fix_layout(figure)
        laid_out = axes.get_position().bounds
        assert laid_out != before
        drawings.clear()
        write(figure, tmp_path / "figure")
    assert len(drawings) == 1
    assert axes.get_position().bounds == laid_out
