"""Batches: cut by what runs cost, and by the study alone."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_study.sweep.batches import MOST_RUNS, WORK_OF_A_BATCH, BatchCut, cost_of_run, cut


@given(runs=st.integers(1, 10_000), size=st.integers(1, 300))
def test_every_run_is_in_one_batch(runs, size):
    cutting = BatchCut(runs, size)
    bounds = [cutting.bounds(number) for number in range(cutting.count)]
    assert [run for first, last in bounds for run in range(first, last)] == list(range(runs))
    assert all(0 < last - first <= size for first, last in bounds)


@pytest.mark.parametrize(
    "changes",
    [
        {"duration": 0.5},
        {"duration": 20.0},
        {"duration": 100.0, "estimator": "inverse_filter"},
        {"duration": 100.0, "estimator": "output_error"},
        {"set": {"plant.lead_screw.efficiency": 0.4}},
        {"configuration": "laboratory", "set": {"twin.decision.kind": "simulate"}},
    ],
)
def test_a_batch_takes_about_as_long_whatever_a_run_costs(study_of, changes):
    study = study_of(**changes)
    size = cut(study).size
    assert 1 <= size <= MOST_RUNS
    assert size * cost_of_run(study) <= WORK_OF_A_BATCH * 1.5 or size == 1


def test_what_costs_more_is_cut_finer(study_of):
    sizes = [
        cut(study_of(duration=20.0, estimator=kind)).size
        for kind in ("none", "inverse_filter", "output_error")
    ]
    assert sizes == sorted(sizes, reverse=True)
    assert len(set(sizes)) == 3
