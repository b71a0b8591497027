"""Looks of the figures: colors that also differ in grey, and SVG that follows the page's theme."""

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

PAPER = "#fffffe"
INK = "#1b1f24"
FAINT = "#8c959e"
GRID = "#e3e6ea"
POSITION = "#0b5cad"
ESTIMATE = "#1a8a5a"
DEAD_ZONE = "#d2691e"
ALARM = "#f9dcd9"
ALARM_INK = "#a3271c"
BAND = "#f6e3d2"
WINDOW = "#eef1f5"
RUNS = ("#0b5cae", "#d2691f", "#1a8a5b", "#a3247a", "#8a7a00", "#5b4bb5")
"""Colors of several runs; each differs from the colors above, so that the page can tell them."""

_VARIABLES = {
    PAPER: "paper",
    INK: "ink",
    FAINT: "faint",
    GRID: "grid",
    POSITION: "position",
    ESTIMATE: "estimate",
    DEAD_ZONE: "dead-zone",
    ALARM: "alarm",
    ALARM_INK: "alarm-ink",
    BAND: "band",
    WINDOW: "window",
} | {color: f"run-{number}" for number, color in enumerate(RUNS, start=1)}
"""CSS variable of each color; the report defines them for light and dark."""

_SETTINGS: dict[Any, Any] = {
    "font.size": 10.0,
    "axes.titlesize": 10.0,
    "axes.labelsize": 10.0,
    "axes.edgecolor": FAINT,
    "axes.facecolor": PAPER,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "text.color": INK,
    "figure.facecolor": PAPER,
    "figure.autolayout": False,
    "figure.constrained_layout.use": False,
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "lines.linewidth": 1.2,
    "svg.fonttype": "none",
    "svg.hashsalt": "bdt",
}


@contextmanager
def house_style() -> Iterator[None]:
    """Draw with the settings of this project and leave matplotlib as it was."""
    with mpl.rc_context(_SETTINGS):
        yield


def new_figure(width: float, height: float) -> Figure:
    """Return a figure of `width` by `height` inches without pyplot's global state."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def fix_layout(figure: Figure) -> None:
    """Lay out a figure once and for all: every rendering would do it again, for half a second."""
    with house_style():
        layout = figure.get_layout_engine()
        if layout is not None:
            layout.execute(figure)
        # Not "none", which leaves an engine that does nothing: for any engine all is drawn twice.
        figure.set_layout_engine(None)


def outside_legend(axes: Axes, columns: int) -> None:
    """Put the legend above the axes, where it hides no data."""
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 0.99),
        ncols=columns,
        borderaxespad=0.1,
        handlelength=2.6,
        columnspacing=1.5,
    )


def svg_text(figure: Figure, name: str) -> str:
    """Return a figure as an SVG element for a page that defines the color variables.

    Parameters
    ----------
    figure : Figure
        The figure.
    name : str
        Prefix that keeps the ids of several figures in one page apart.
    """
    buffer = io.StringIO()
    with house_style():
        FigureCanvasSVG(figure)
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    # The page sets the size of the picture; the outermost element is all that goes without.
    head, rest = text.split(">", 1)
    text = re.sub(r' (?:xmlns(?::\w+)?|width|height)="[^"]*"', "", head) + ">" + rest
    text = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", text)
    text = re.sub(r"'DejaVu Sans'[^;\"]*sans-serif", "var(--font)", text)
    for color, variable in _VARIABLES.items():
        text = text.replace(color, f"var(--{variable})")
    return text


def write_png(figure: Figure, path: Path, resolution: float = 150.0) -> None:
    """Write a figure as a PNG with `resolution` dots per inch, in the light colors."""
    with house_style():
        metadata: dict[str, Any] = {"Software": None}
        FigureCanvasAgg(figure)
        figure.savefig(path, format="png", dpi=resolution, metadata=metadata)


def write_svg(figure: Figure, path: Path) -> None:
    """Write a figure as an SVG file that stands by itself, in the light colors."""
    with house_style():
        FigureCanvasSVG(figure)
        figure.savefig(path, format="svg", metadata={"Date": None})
