"""Study files: read whole or refused in one line that says what is allowed."""

from pathlib import Path

import pytest

from bdt_msgs_py.command_errors import BadInputError
from bdt_study.sweep.batches import WORK_OF_A_BATCH, cost_of_run, cut
from bdt_study.sweep.study_file import packaged_studies, read_study

STUDIES = Path(__file__).parents[3] / "config" / "studies"


def test_a_study_is_read_with_its_configuration_and_what_it_changes(study_of):
    study = study_of(configuration="laboratory", set={"plant.gap.kind": "constant"})
    settings = dict(study.settings)
    assert settings["plant.sensor.noise"] == 1e-6
    assert settings["plant.gap.kind"] == "constant"
    assert study.runs == 3 * 2 * 4 * 2
    assert [axis.name for axis in study.grid_axes] == [
        "plant.gap.initial",
        "controller.dead_zone_tolerance",
    ]
    assert study.drawn_axes[0].also == ("twin.structure.damping",)


def test_a_configuration_beside_the_study_comes_first(study_file, tmp_path):
    (tmp_path / "mine.yaml").write_text("plant: {ros__parameters: {sensor: {noise: 2.0e-6}}}")
    study = read_study(study_file(configuration="mine.yaml"))
    assert dict(study.settings)["plant.sensor.noise"] == 2e-6


def test_without_an_estimator_of_its_own_a_study_has_that_of_the_configuration(study_of):
    assert study_of(configuration="laboratory", estimator=None).estimator == "output_error"
    assert study_of(estimator=None).estimator == "inverse_filter"


def test_the_same_file_is_the_same_study_and_another_seed_another_one(study_of):
    assert study_of().text == study_of().text
    assert study_of().text != study_of(seed=1).text


VARY = "plant.gap.initial"


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"typo": 1}, "typo: must be one of configuration, duration"),
        ({"set": {"plant.gap.intial": 1.0}}, "did you mean plant.gap.initial?"),
        ({"set": {"plant.gap.initial": -1.0}}, "plant.gap.initial = -1.0 rad: must be 0 to 100"),
        ({"set": {"plant.gap.initial": 1}}, "must be written with a decimal point"),
        ({"vary": {"plant.lockstep_timeout": {"values": [1.0]}}}, "is not a parameter of a loop"),
        ({"vary": {VARY: {"values": []}}}, "values = []: must be a list"),
        ({"vary": {VARY: {"values": [0.1, 200.0]}}}, "= 200.0 rad: must be 0 to 100"),
        ({"vary": {VARY: {"from": 0.0, "to": 1.0, "count": 1}}}, "count = 1: must be 2 to"),
        ({"vary": {VARY: {"from": 0.0, "to": 1.0}}}, "from, to: must be values, from with to"),
        ({"vary": {VARY: {"uniform": [0.0]}}}, "uniform = [0.0]: must be a list of two numbers"),
        ({"vary": {VARY: {"uniform": [-1.0, 1.0]}}}, "= -1.0 rad: must be 0 to 100"),
        ({"vary": {VARY: {"values": [0.1], "also": [VARY]}}}, "is varied twice"),
        ({"sample": {"method": "sobol", "count": 3}}, "count = 3: must be a power of two"),
        ({"sample": {"method": "halton"}}, "must be one of random, latin_hypercube, sobol"),
        ({"sample": {"size": 3}}, "sample.size: must be method or count"),
        ({"repetitions": 0}, "repetitions = 0: must be an integer, at least 1"),
        ({"duration": 0.0}, "duration = 0.0 s: must be above 0"),
        ({"estimator": "kalman"}, "'kalman': must be one of inverse_filter, output_error"),
        ({"compute": ["bias"]}, "must be one of limit_cycle, "),
        ({"compute": ["estimate_coverage"]}, "needs an estimator, which is none"),
        ({"compute": ["no_such_module:peak"]}, "No module named 'no_such_module'"),
        ({"configuration": "papre"}, "did you mean paper?"),
        ({"set": {"controller.reference.kind": "topic"}}, "must be one of square, table"),
        (
            {
                "vary": {"twin.dead_zone.minimum": {"values": [0.0, 0.5]}},
                "set": {"twin.dead_zone.maximum": 0.1},
                "sample": None,
            },
            "twin: dead_zone.minimum = 0.5 m: must be at most maximum (0.1 m)",
        ),
    ],
)
def test_a_mistake_is_one_line_that_says_what_is_allowed(study_file, changes, says):
    path = study_file(**changes)
    with pytest.raises(BadInputError) as refused:
        read_study(path)
    text = str(refused.value)
    assert says in text
    assert text.count(str(path)) <= 1
    assert "\n" not in text


@pytest.mark.parametrize(
    ("text", "says"), [("a: [", "is not YAML"), ("", "must be names with values")]
)
def test_what_is_no_study_is_refused(tmp_path, text, says):
    (tmp_path / "odd.yaml").write_text(text)
    with pytest.raises(BadInputError, match=says):
        read_study(tmp_path / "odd.yaml")
    with pytest.raises(BadInputError, match=r"missing\.yaml: cannot be read: No such file"):
        read_study(tmp_path / "missing.yaml")


def test_the_packaged_studies_are_those_of_the_folder_that_people_copy_from():
    packaged = packaged_studies()
    assert {path.name for path in packaged.values()} == {path.name for path in STUDIES.iterdir()}
    for path in packaged.values():
        assert path.read_bytes() == (STUDIES / path.name).read_bytes(), path


@pytest.mark.parametrize("name", packaged_studies())
def test_a_packaged_study_is_read_by_its_name(name):
    study = read_study(name)
    assert study.name == name
    assert study.runs > 100
    assert cut(study).size * cost_of_run(study) < 10.0 * WORK_OF_A_BATCH


def test_a_file_comes_before_a_packaged_study_of_that_name(tmp_path, monkeypatch, study_file):
    monkeypatch.chdir(tmp_path)
    study_file().rename(tmp_path / "gap_delay")
    assert read_study("gap_delay").runs == 48
    with pytest.raises(BadInputError, match=r"must be one of friction_gap, .*did you mean gap_del"):
        read_study("gap_delays")
