"""The data set of a sweep: a row for each run, for anybody's reader."""

import json

import numpy as np
import pytest
from pyarrow import dataset, parquet

from bdt_msgs_py.command_errors import BadInputError
from bdt_study.engine.part_folder import part_name
from bdt_study.sweep.data_set import METADATA, DataSet
from bdt_study.sweep.run_batch import Batch
from bdt_study.sweep.run_points import RunPoints


@pytest.fixture
def small(study_of, monkeypatch, tmp_path):
    """Return a study, its data set in four parts, and a function that works on one of them."""
    monkeypatch.setattr("bdt_study.sweep.batches.MOST_RUNS", 13)
    study = study_of()
    data = DataSet(tmp_path / "sweep", study)
    points = RunPoints(study)

    def result(number):
        return Batch(number, study, points.between(*data.cutting.bounds(number))).run()

    return study, data, result


def test_parts_hold_parameters_quantities_and_where_they_come_from(small):
    study, data, result = small
    data.create(resume=False)
    for number in (3, 0, 2, 1):
        data.write(number, result(number))
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
    data.write(0, unknown)
    table = parquet.read_table(data.parts_folder / part_name(0))
    assert table.column("bias_percent").null_count == 1
    assert table.column("bias_percent")[2].as_py() is None


def test_the_data_set_of_another_study_is_left_alone(small, study_of):
    _, data, _ = small
    data.create(resume=False)
    other = DataSet(data.folder, study_of(seed=5, repetitions=1))
    with pytest.raises(BadInputError, match="which differs in repetitions, seed"):
        other.create(resume=True)
