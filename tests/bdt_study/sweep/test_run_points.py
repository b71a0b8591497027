"""Which values and seeds a run has: those of its number, whatever else is asked for."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_study.sweep.axis import Axis
from bdt_study.sweep.run_points import RunPoints, saltelli_design
from bdt_study.sweep.study import METHODS, Study

GRID = Axis("plant.gap.initial", values=(0.1, 0.2, 0.3))
DRAWN = (
    Axis("plant.structure.damping", distribution="uniform", first=30.0, second=40.0),
    Axis("plant.structure.mass", distribution="normal", first=5.0, second=0.1),
)


def study(**changes):
    values = {"axes": (GRID, *DRAWN), "samples": 8, "repetitions": 2, "seed": 7}
    return Study("drawn", (), 1.0, "none", **(values | changes))


@pytest.mark.parametrize("method", METHODS)
@given(cuts=st.lists(st.integers(1, 47), unique=True).map(sorted))
def test_a_run_has_the_same_values_and_seed_however_the_study_is_cut(method, cuts):
    asked = study(method=method)
    whole = RunPoints(asked).between(0, asked.runs)
    parts = [
        RunPoints(asked).between(first, last) for first, last in pairwise([0, *cuts, asked.runs])
    ]
    assert [seed for part in parts for seed in part.seeds] == whole.seeds
    for place, column in enumerate(whole.columns):
        assert [value for part in parts for value in part.columns[place]] == column


def test_the_order_is_grid_then_samples_then_repetitions():
    points = RunPoints(study()).between(0, 48)
    gaps, dampings, _ = points.columns
    assert gaps == [0.1] * 16 + [0.2] * 16 + [0.3] * 16
    assert dampings[::2] == dampings[1::2]
    assert dampings[:16] == dampings[16:32], "cells of the grid have the samples in common"
    assert points.repetitions == [0, 1] * 24
    assert len(set(points.seeds)) == 48


@pytest.mark.parametrize("method", ["latin_hypercube", "sobol"])
def test_a_sample_has_one_value_in_each_eighth_of_every_axis(method):
    uniform = [Axis(name, distribution="uniform", second=8.0) for name in ("a.b", "a.c", "a.d")]
    points = RunPoints(study(axes=tuple(uniform), method=method, repetitions=1)).between(0, 8)
    for column in points.columns:
        assert sorted(np.floor(column)) == list(range(8))


def test_another_seed_draws_something_else():
    first, other = (RunPoints(study(seed=seed)).between(0, 48) for seed in (0, 1))
    assert first.columns[1] != other.columns[1]
    assert not set(first.seeds) & set(other.seeds)


def test_the_design_for_indices_is_in_the_order_of_salib():
    sample = pytest.importorskip("SALib.sample.sobol").sample
    problem = {"num_vars": 3, "names": list("abc"), "bounds": [[0.0, 1.0]] * 3}
    theirs = sample(problem, 8, calc_second_order=False, scramble=False)
    ours = saltelli_design(theirs[::5], theirs[4::5])
    np.testing.assert_array_equal(ours, theirs)
