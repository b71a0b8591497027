"""`bdt sweep report` and `replay`: what a data set tells, and one row of it again."""

import json

import numpy as np
import pytest
import yaml

from bdt_bringup.cli import run_command
from bdt_bringup.configuration import load_configuration
from bdt_msgs_py.command_errors import BAD_INPUT
from bdt_study.simulation.configured_loop import LoopParameters
from bdt_study.sweep.batches import batches
from bdt_study.sweep.data_set import DataSet
from bdt_study.sweep.replay import run_configuration
from bdt_study.sweep.run_batch import run_result
from bdt_study.sweep.study import study_from_text
from bdt_study.sweep.study_file import read_study
from bdt_study.sweep.sweep_table import open_study, read_run, read_runs

CHANGES = {
    "estimator": "inverse_filter",
    "set": {
        "plant.gap.kind": "constant",
        "controller.reference.step_time": 2.0,
        "plant.sensor.noise": 1e-9,
    },
    "vary": {
        "plant.gap.initial": {"from": 0.02, "to": 0.5, "count": 3},
        "twin.estimator.rounding": {"uniform": [0.05, 0.2]},
        "twin.reconfigure": {"values": [True, False]},
    },
    "repetitions": 1,
}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """Return the folder of a sweep of 24 runs with a twin."""
    folder = tmp_path_factory.mktemp("finished")
    path = folder / "twins.yaml"
    document = {
        "duration": 4.0,
        "sample": {"count": 4},
        "compute": ["limit_cycle", "bias_percent", "estimate_rms_error_rad"],
        **CHANGES,
    }
    path.write_text(yaml.safe_dump(document, sort_keys=False))
    study = read_study(path)
    data = DataSet(folder / "sweep", study)
    data.create(resume=False)
    for batch in batches(study, data.missing()):
        data.write(batch.number, batch.run())
    return data.folder


def test_a_study_is_read_from_the_data_set_as_it_was(finished):
    study = open_study(finished)
    assert study == read_study(finished.parent / "twins.yaml")
    assert study_from_text(study.text) == study


def test_the_page_holds_everything_and_loads_nothing(finished, capsys):
    assert run_command(["sweep", "report", str(finished)]) == 0
    page = (finished / "report.html").read_text()
    assert "24 of 24 runs" in page
    assert "src=" not in page.replace("default-src", "").replace("-src", "")
    for run in range(24):
        if f"bdt sweep replay {finished} {run}<" in page:
            break
    else:
        pytest.fail("no run can be replayed")


def test_the_answers_as_json_have_maps_with_intervals_and_the_papers_point(finished, capsys):
    assert run_command(["sweep", "report", str(finished), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    gap = told["axes"][0]
    assert gap["paper"] == pytest.approx(np.deg2rad(10.0))
    assert told["axes"][2]["values"] == ["True", "False"]
    (chance,) = (
        one
        for one in told["maps"]
        if one["quantity"] == "limit_cycle"
        and one["axes"] == ["plant.gap.initial", "twin.reconfigure"]
    )
    assert np.array(chance["counts"]).tolist() == [[4, 4, 4], [4, 4, 4]]
    values, low, high = (np.array(chance[key]) for key in ("values", "low", "high"))
    assert ((low <= values) & (values <= high)).all()
    biases = read_runs(finished, open_study(finished)).columns
    reached = [run["limit_cycle"] for run in told["worst"]]
    assert reached == sorted(reached, reverse=True)
    assert reached[0] == biases["limit_cycle"].max()


def test_a_row_as_a_configuration_is_the_loop_of_that_row(finished, tmp_path):
    study, row = open_study(finished), read_run(finished, 17)
    path = tmp_path / "row.yaml"
    path.write_text(run_configuration(study, row))
    values = load_configuration(path).values
    parameters = LoopParameters.from_values(values)
    result = run_result(study, [row[axis.name] for axis in study.axes], row["seed"], 17)
    loop = result.scenario
    again = parameters.scenario(values["plant"]["duration"])
    for part in (
        "duration",
        "reference",
        "gap",
        "dead_zone",
        "model",
        "gains",
        "sampling",
        "sensor",
    ):
        assert getattr(again, part) == getattr(loop, part)
    assert parameters.twin() == parameters.twin(row["seed"])


def test_without_an_estimator_the_twin_leaves_the_dead_zone_alone(study_of):
    study = study_of()
    row = {"run": 3, "seed": 1, **{axis.name: axis.extremes[0] for axis in study.axes}}
    document = yaml.safe_load(run_configuration(study, row))
    assert document["/**/twin"]["ros__parameters"]["reconfigure"] is False
    assert document["/**/twin"]["ros__parameters"]["structure"]["damping"] == 30.0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["report"], "bdt sweep report: must be report DIR"),
        (["replay", "DIR"], "must be replay DIR RUN"),
        (["replay", "DIR", "first"], "RUN 'first': must be the number of a run"),
        (["replay", "DIR", "24"], "has no run 24"),
        (["report", "/nowhere"], "/nowhere: holds no sweep: No such file"),
        (["report", "DIR", "--output", "page.txt"], "must end with .html"),
    ],
)
def test_what_cannot_be_told_is_one_line(finished, capsys, arguments, says):
    words = [str(finished) if word == "DIR" else word for word in arguments]
    assert run_command(["sweep", *words]) == BAD_INPUT
    told = capsys.readouterr().err
    assert says in told
    assert told.count("\n") == 1
