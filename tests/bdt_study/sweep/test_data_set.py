"""The data set: whole parts alone, for anybody's reader, and nobody's else."""

import errno
import json

import numpy as np
import pytest
from pyarrow import dataset, parquet

from bdt_msgs_py.command_errors import BadInputError
from bdt_study.sweep import data_set
from bdt_study.sweep.data_set import METADATA, DataSet, part_name
from bdt_study.sweep.run_batch import Batch, run_batch
from bdt_study.sweep.run_points import RunPoints


@pytest.fixture
def small(study_of, monkeypatch, tmp_path):
    """Return a study, its data set in four parts, and a function that works on one of them."""
    monkeypatch.setattr("bdt_study.sweep.batches.MOST_RUNS", 13)
    study = study_of()
    data = DataSet(tmp_path / "sweep", study)
    points = RunPoints(study)

    def result(number):
        return run_batch(Batch(number, study, points.between(*data.cutting.bounds(number))))

    return study, data, result


def test_parts_hold_parameters_quantities_and_where_they_come_from(small):
    study, data, result = small
    data.create(resume=False)
    for number in (3, 0, 2, 1):
        data.write(result(number))
    table = dataset.dataset(data.parts_folder).to_table()
    assert table.column("run").to_pylist() == list(range(48))
    assert set(table.column("plant.gap.initial").to_pylist()) == {0.02, 0.26, 0.5}
    expected = np.concatenate([result(number).values for number in range(4)])
    for name, column in zip(study.compute, expected.T, strict=True):
        np.testing.assert_array_equal(table.column(name).to_numpy(), column)
    schema = parquet.read_schema(data.parts_folder / part_name(0))
    assert json.loads(schema.metadata[METADATA])["seed"] == 0
    assert b"[rad]" in schema.field("plant.gap.initial").metadata[b"description"]


def test_what_is_unknown_is_empty_and_not_nan(small):
    _, data, result = small
    data.create(resume=False)
    unknown = result(0)
    unknown.values[2, 1] = np.nan
    data.write(unknown)
    table = parquet.read_table(data.parts_folder / part_name(0))
    assert table.column("bias_percent").null_count == 1
    assert table.column("bias_percent")[2].as_py() is None


def test_a_sweep_is_taken_up_with_the_parts_that_are_whole(small):
    _, data, result = small
    data.create(resume=False)
    data.write(result(1))
    left = data.parts_folder / f"{part_name(2)}.tmp"
    left.write_bytes(b"half a part")
    data.create(resume=True)
    assert data.missing() == [0, 2, 3]
    assert not left.exists()


@pytest.mark.parametrize("left", [None, "study.json.tmp", "study.json"])
def test_a_sweep_that_was_killed_at_its_very_beginning_begins_anew(small, left):
    study, data, _ = small
    data.folder.mkdir()
    if left is not None:
        (data.folder / left).write_text(study.text if left == "study.json" else "{")
    data.create(resume=True)
    assert data.missing() == [0, 1, 2, 3]


def test_a_folder_that_holds_runs_needs_to_be_told_to_go_on(small):
    _, data, _ = small
    data.create(resume=False)
    with pytest.raises(BadInputError, match="already holds this sweep: go on with --resume"):
        data.create(resume=False)


def test_the_data_set_of_another_study_is_left_alone(small, study_of):
    _, data, _ = small
    data.create(resume=False)
    other = DataSet(data.folder, study_of(seed=5, repetitions=1))
    with pytest.raises(BadInputError, match="which differs in repetitions, seed"):
        other.create(resume=True)
    (data.folder / "study.json").write_text("{}")
    with pytest.raises(BadInputError, match=r"its study\.json cannot be read"):
        other.create(resume=True)


def test_a_folder_of_something_else_is_left_alone(small, tmp_path):
    study, _, _ = small
    (tmp_path / "letters").mkdir()
    (tmp_path / "letters" / "aunt.txt").write_text("Dear aunt")
    with pytest.raises(BadInputError, match="holds something that is no sweep"):
        DataSet(tmp_path / "letters", study).create(resume=True)


def test_a_full_disk_leaves_nothing_that_is_not_whole(small, monkeypatch):
    _, data, result = small
    data.create(resume=False)

    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(data_set.os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        data.write(result(0))
    assert list(data.parts_folder.iterdir()) == []
