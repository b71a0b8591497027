"""How far a parameter can go from where it is before the loop is likely to have a limit cycle."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_study.sweep.cells import Shares

FloatArray = NDArray[np.float64]

LIKELY = 0.05
"""Probability of a limit cycle beyond which a value counts as unsafe."""


@dataclass(frozen=True)
class Margin:
    """What is safe along a parameter.

    Attributes
    ----------
    parameter : str
        Its name.
    point : float
        Value from which the margin is reckoned.
    lowest, highest : float or None
        Ends of the safe values around it; None where not even its own cell is safe.
    reaches_low, reaches_high : bool
        Whether these are the ends of what was tried, so that more may be safe.
    """

    parameter: str
    point: float
    lowest: float | None
    highest: float | None
    reaches_low: bool = False
    reaches_high: bool = False


def margin_of(parameter: str, point: float, values: FloatArray, shares: Shares) -> Margin:
    """Return the safe values around a point.

    Parameters
    ----------
    parameter : str
        Name of the parameter.
    point : float
        Where the loop is.
    values : ndarray, shape (n,)
        Values of the cells, increasing.
    shares : Shares
        How often there is a limit cycle in each cell. A cell is safe if the observed share is at
        most 5 %.
    """
    safe = np.nan_to_num(shares.shares, nan=1.0) <= LIKELY
    place = int(np.argmin(np.abs(values - point)))
    if not safe[place]:
        return Margin(parameter, point, None, None)
    first = last = place
    while first > 0 and safe[first - 1]:
        first -= 1
    while last < values.size - 1 and safe[last + 1]:
        last += 1
    return Margin(
        parameter,
        point,
        float(values[first]),
        float(values[last]),
        first == 0,
        last == values.size - 1,
    )
