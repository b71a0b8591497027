"""Indices of a model whose indices are known: a sum of independent parameters."""

import numpy as np
import pytest

from bdt_study.sweep.axis import Axis
from bdt_study.sweep.run_points import RunPoints
from bdt_study.sweep.sobol_indices import has_indices, sobol_indices
from bdt_study.sweep.study import Study
from bdt_study.sweep.sweep_table import SweepTable

NAMES = ("plant.a", "plant.b", "plant.c")
AXES = tuple(Axis(name, distribution="uniform", second=1.0) for name in NAMES)
STUDY = Study("sum", (), 1.0, "none", AXES, "saltelli", samples=512, compute=("y", "z"))


@pytest.fixture(scope="module")
def table():
    points = RunPoints(STUDY).between(0, STUDY.runs)
    columns = dict(zip(NAMES, map(np.array, points.columns), strict=True))
    first, second, _ = columns.values()
    columns["y"] = 3.0 * first + 4.0 * second
    columns["z"] = first * second
    return SweepTable(STUDY, np.arange(STUDY.runs), columns)


def test_shares_of_a_sum_are_the_squares_of_its_factors(table):
    found, product = sobol_indices(table, ("y", "z"))
    assert found.first == pytest.approx((0.36, 0.64, 0.0), abs=0.02)
    assert found.total == pytest.approx((0.36, 0.64, 0.0), abs=0.02)
    # Var(E(xy|x)) / Var(xy) = (1/48) / (7/144) = 3/7, and the rest is what they do together.
    assert product.first[:2] == pytest.approx((3 / 7, 3 / 7), abs=0.03)
    assert product.total[:2] == pytest.approx((4 / 7, 4 / 7), abs=0.03)


def test_samples_with_an_unknown_run_are_left_out_whole(table):
    values = table.columns["y"].copy()
    values[[0, 7, 8]] = np.nan
    (found,) = sobol_indices(SweepTable(STUDY, table.runs, {**table.columns, "y": values}), ("y",))
    assert (found.left_out, found.samples) == (2, 510)
    assert found.first == pytest.approx((0.36, 0.64, 0.0), abs=0.03)


def test_a_quantity_that_never_changes_has_no_indices(table):
    flat = {**table.columns, "y": np.ones(STUDY.runs)}
    assert sobol_indices(SweepTable(STUDY, table.runs, flat), ("y",)) == []


def test_a_sweep_that_is_not_done_has_no_indices(table):
    assert has_indices(table)
    assert not has_indices(SweepTable(STUDY, table.runs[:-1], table.columns))
