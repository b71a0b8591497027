"""Trials on the disk: what is read is what was run, to the last bit, and anybody can read it."""

import math
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from bdt_msgs_py.command_errors import BadInputError
from bdt_study.evaluation.cases import CASES
from bdt_study.evaluation.trial import Trial
from bdt_study.evaluation.trial_job import Evaluation, FinishedTrial, Twin

trial_folder = pytest.importorskip(
    "bdt_study.evaluation.trial_folder", reason="beside a ROS 2 without pyarrow"
)

TWIN = Twin("output_error", "equation_9")
EVALUATION = Evaluation(CASES[:1], (TWIN,), first_seed=5, scenarios=3)
NUMBERS = arrays.arrays(np.float64, st.integers(0, 6), elements=st.floats(width=64))
COUNTS = st.integers(0, 100)
TRIALS = st.builds(
    Trial,
    **dict.fromkeys(
        (
            "errors",
            "uncertainties",
            "bounds",
            "bound_errors",
            "window_times",
            "settling_times",
        ),
        NUMBERS,
    ),
    **dict.fromkeys(
        ("limit_cycles", "avoidable_limit_cycles", "avoidable_steps", "taken_back"), COUNTS
    ),
    worst_bias=st.floats(0.0),
)


def written(folder, *trials):
    """Return a folder with trials of the scenarios from the first on."""
    kept = trial_folder.TrialFolder(folder, EVALUATION)
    kept.create(resume=True)
    for number, trial in enumerate(trials):
        kept.write(number, FinishedTrial("clean", TWIN, 5 + number, trial))
    return kept


def a_trial(**changes):
    numbers = np.array([0.1, math.nan, -0.2])
    settling = np.array([2.0, math.inf])
    told = {"settling_times": settling} | changes
    return Trial(numbers, abs(numbers), numbers[:1], numbers[:1], 2, 0.5, numbers[::2], **told)


@given(trial=TRIALS)
def test_what_is_read_is_what_was_written(tmp_path_factory, trial):
    kept = written(tmp_path_factory.mktemp("trials"), trial)
    ((case, twin, seed, read),) = kept.finished()
    assert (case, twin, seed) == ("clean", TWIN, 5)
    for field in fields(Trial):
        np.testing.assert_array_equal(getattr(read, field.name), getattr(trial, field.name))


def test_every_field_of_a_trial_has_a_column_with_its_meaning():
    columns = trial_folder.COLUMNS
    assert sorted(column.field for column in columns) == sorted(each.name for each in fields(Trial))
    for field in trial_folder.SCHEMA:
        assert field.metadata[b"description"]


def test_what_is_unknown_is_empty_and_neither_nan_nor_infinite(tmp_path):
    from pyarrow import dataset

    kept = written(tmp_path, a_trial())
    (row,) = dataset.dataset(kept.parts_folder).to_table().to_pylist()
    assert row["errors_rad"] == [0.1, None, -0.2]
    assert row["settling_times_s"] == [2.0, None]
    assert (row["case"], row["estimator"], row["seed"]) == ("clean", "output_error", 5)


def test_scenarios_that_nobody_asks_for_are_left_out(tmp_path):
    written(tmp_path, *[a_trial()] * 3)
    fewer = Evaluation(CASES[:1], (TWIN,), first_seed=5, scenarios=2)
    kept = trial_folder.TrialFolder(tmp_path, fewer)
    assert sorted(one.seed for one in kept.finished()) == [5, 6]
    assert kept.missing() == []


def test_before_the_first_trial_is_finished_there_is_none(tmp_path):
    kept = written(tmp_path)
    assert list(kept.finished()) == []
    assert kept.missing() == [0, 1, 2]


def test_a_part_that_is_none_is_told(tmp_path):
    kept = written(tmp_path, a_trial())
    (kept.parts_folder / "part-0000001.parquet").write_bytes(b"something else")
    with pytest.raises(BadInputError, match="runs: cannot be read"):
        list(kept.finished())
