"""The trials of an evaluation have numbers that stay when more are asked for."""

import json
from dataclasses import replace

import pytest

from bdt_study.evaluation.cases import CASES
from bdt_study.evaluation.trial_job import Evaluation, Twin

TWINS = (Twin("inverse_filter", "equation_9"), Twin("inverse_filter", "simulate"))


@pytest.fixture
def evaluation():
    return Evaluation(CASES[:3], TWINS, first_seed=7, scenarios=2)


def what(job):
    return job.case.name, job.twin, job.seed


def test_each_case_is_tried_with_each_twin_on_each_scenario(evaluation):
    jobs = list(evaluation.jobs(range(evaluation.trials)))
    assert [job.number for job in jobs] == list(range(12))
    assert {what(job) for job in jobs} == {
        (case.name, twin, seed) for case in CASES[:3] for twin in TWINS for seed in (7, 8)
    }
    assert jobs[-1].name == "harsh with inverse_filter, simulate, seed 8"


def test_a_twin_that_is_not_told_how_to_decide_does_as_the_case_has_it(evaluation):
    cases = CASES[0], replace(CASES[1], decision="simulate")
    untold = replace(evaluation, cases=cases, twins=(Twin("output_error"), TWINS[0]), scenarios=1)
    tried = {(job.case.name, job.twin) for job in untold.jobs(range(untold.trials))}
    assert tried == {
        ("clean", Twin("output_error", "equation_9")),
        ("laboratory", Twin("output_error", "simulate")),
        ("clean", TWINS[0]),
        ("laboratory", TWINS[0]),
    }


def test_more_scenarios_only_add_trials(evaluation):
    more = replace(evaluation, scenarios=5)
    assert more.text == evaluation.text
    first = more.jobs(range(evaluation.trials))
    assert list(first) == list(evaluation.jobs(range(evaluation.trials)))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"first_seed": 8}, {"seed"}),
        ({"cases": CASES[1:4]}, {"cases"}),
        ({"cases": (replace(CASES[0], noise=1e-9), *CASES[1:3])}, {"cases"}),
        ({"twins": TWINS[::-1]}, {"decisions"}),
        ({"twins": (Twin("my:Own", "equation_9"), TWINS[1])}, {"estimators"}),
    ],
)
def test_whatever_else_changes_makes_it_another_evaluation(evaluation, change, told):
    here, there = (json.loads(one.text) for one in (evaluation, replace(evaluation, **change)))
    assert {key for key, value in here.items() if there[key] != value} == told
