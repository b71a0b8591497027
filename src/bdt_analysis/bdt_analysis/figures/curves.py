"""Curves of interactive plots and the panels in which they stand."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Panel:
    """One plot above the common time axis.

    Attributes
    ----------
    key : str
        Name by which a curve says where it belongs.
    quantity, unit : str
        What the axis says.
    range : tuple of float, optional
        Lower and upper end at first [unit]; None shows everything.
    """

    key: str
    quantity: str
    unit: str
    range: tuple[float, float] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """One curve.

    Attributes
    ----------
    panel : str
        Key of its panel.
    name : str
        What the legend says.
    color : str
        CSS variable of the page, without the dashes.
    time, value : ndarray, shape (n,)
        Points [s, unit of the panel]; NaN interrupts the line.
    run : int
        Index of the run, if there are several.
    steps : bool
        True for a value that holds until the next point.
    dash : str
        Plotly's name of the line style.
    width : float
        Width of the line [px].
    fill : bool
        True to fill the area down to the series before.
    quiet : bool
        True for the second edge of a band, which needs no legend.
    samples : int
        Number of samples behind the points.
    bin_width : float or None
        Width of the time bins of which only the extremes are held [s]; None when `time` and
        `value` are every sample.
    """

    panel: str
    name: str
    color: str
    time: FloatArray
    value: FloatArray
    run: int = 0
    steps: bool = False
    dash: Literal["solid", "dash", "dot"] = "solid"
    width: float = 1.4
    fill: bool = False
    quiet: bool = False
    samples: int = 0
    bin_width: float | None = None
