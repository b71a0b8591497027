"""What a data set tells: probabilities over parameters, margins, indices, the worst runs."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.parameter_tables import known_parameters
from bdt_study.simulation.configured_loop import TABLES
from bdt_study.sweep.axis import Axis
from bdt_study.sweep.cells import Shares, binned, means_of, shares_of
from bdt_study.sweep.margins import Margin, margin_of
from bdt_study.sweep.paper_point import paper_value
from bdt_study.sweep.sobol_indices import SobolIndices, has_indices, sobol_indices
from bdt_study.sweep.sweep_table import SweepTable, is_numeric

FloatArray = NDArray[np.float64]

CYCLE = "limit_cycle"
"""Quantity that is a probability over many runs."""
MOST_AXES = 6
"""Parameters of which every pair has a map."""
WORST = 10


@dataclass(frozen=True, eq=False)
class ShownAxis:
    """A parameter on the page.

    Attributes
    ----------
    name, unit : str
        Node and flat name, and unit.
    values : list
        Middles of its cells: numbers, or the words themselves.
    places : ndarray of int, shape (n,)
        Cell of each run.
    paper : float or None
        The paper's value; None where it has none within what was tried.
    """

    name: str
    unit: str
    values: list[Any]
    places: NDArray[np.int64]
    paper: float | None


@dataclass(frozen=True, eq=False)
class QuantityMap:
    """A quantity over one parameter or two.

    Attributes
    ----------
    quantity : str
        Its name; of ``limit_cycle`` the probability.
    axes : tuple of str
        The parameters: the first one to the right, the second one upward.
    values : ndarray
        Its mean in each cell.
    shares : Shares or None
        Of ``limit_cycle``: counts and intervals, too.
    """

    quantity: str
    axes: tuple[str, ...]
    values: FloatArray
    shares: Shares | None = None


@dataclass(frozen=True, eq=False)
class SweepAnswers:
    """All that a data set tells.

    Attributes
    ----------
    table : SweepTable
        The runs.
    axes : tuple of ShownAxis
        The parameters that have more than one value.
    cycles : Shares or None
        Limit cycles in all runs; None if nobody asked for them.
    maps : list of QuantityMap
        Over one parameter, and over each pair.
    margins : list of Margin
        Around the paper's value of each parameter.
    indices : list of SobolIndices
        Empty for a study that is not sampled for them.
    worst : list of (int, dict)
        Number and quantities of the runs with the largest ones, those with a limit cycle first.
    """

    table: SweepTable
    axes: tuple[ShownAxis, ...]
    cycles: Shares | None
    maps: list[QuantityMap]
    margins: list[Margin]
    indices: list[SobolIndices]
    worst: list[tuple[int, dict[str, float]]]


def answers_of(table: SweepTable) -> SweepAnswers:
    """Return what a data set tells."""
    axes = tuple(_shown(axis, table) for axis in table.study.axes)
    axes = tuple(axis for axis in axes if len(axis.values) > 1)[:MOST_AXES]
    cycles = table.columns.get(CYCLE)
    return SweepAnswers(
        table,
        axes,
        None if cycles is None else shares_of(cycles, np.zeros(cycles.size, int), shape=(1,)),
        list(_maps(table, axes)),
        list(_margins(table, axes)),
        sobol_indices(table, table.study.compute) if has_indices(table) else [],
        _worst(table),
    )


def _shown(axis: Axis, table: SweepTable) -> ShownAxis:
    node, _, flat = axis.name.partition(".")
    _, described = known_parameters(TABLES[node])[flat]
    column = table.columns[axis.name]
    if not is_numeric(axis.values):
        words = [str(value) for value in axis.values]
        return ShownAxis(axis.name, described.unit, words, column.astype(int), None)
    values, places = binned(column)
    paper = paper_value(axis.name)
    inside = paper is not None and float(column.min()) <= paper <= float(column.max())
    return ShownAxis(axis.name, described.unit, values.tolist(), places, paper if inside else None)


def _maps(table: SweepTable, axes: tuple[ShownAxis, ...]) -> Iterator[QuantityMap]:
    groups = [(axis,) for axis in axes] + list(combinations(axes, 2))
    for shown in groups:
        names = tuple(axis.name for axis in shown)
        # Rows of a matrix lie above each other: the second parameter comes first.
        places = [axis.places for axis in reversed(shown)]
        shape = tuple(len(axis.values) for axis in reversed(shown))
        for quantity in table.study.compute:
            column = table.columns[quantity]
            if quantity == CYCLE:
                shares = shares_of(column, *places, shape=shape)
                yield QuantityMap(quantity, names, shares.shares, shares)
            else:
                yield QuantityMap(quantity, names, means_of(column, *places, shape=shape))


def _margins(table: SweepTable, axes: tuple[ShownAxis, ...]) -> Iterator[Margin]:
    """Iterate over the margins along each parameter, with the rest of the grid at the paper's."""
    cycles = table.columns.get(CYCLE)
    if cycles is None:
        return
    grid = {axis.name for axis in table.study.grid_axes}
    for axis in axes:
        if axis.paper is None:
            continue
        others = [one for one in axes if one is not axis and one.name in grid]
        near = np.ones(cycles.size, dtype=np.bool_)
        for other in others:
            if other.paper is not None:
                near &= other.places == np.argmin(np.abs(np.array(other.values) - other.paper))
        shares = shares_of(cycles[near], axis.places[near], shape=(len(axis.values),))
        yield margin_of(axis.name, axis.paper, np.array(axis.values), shares)


def _worst(table: SweepTable) -> list[tuple[int, dict[str, float]]]:
    """Return the runs with the largest quantities, compared in the order of the study."""
    keys = [np.nan_to_num(table.columns[name], nan=-np.inf) for name in table.study.compute]
    order = np.lexsort(keys[::-1])[::-1][:WORST]
    return [
        (
            int(table.runs[place]),
            {name: float(table.columns[name][place]) for name in table.columns},
        )
        for place in order
    ]
