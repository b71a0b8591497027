"""Ranges of a mechanism: corners, and what a calibration tells."""

import json

import pytest

from bdt_msgs_py.command_errors import BadInputError
from bdt_plant.plant import PlantModel
from bdt_study.tuning.mechanism_ranges import MechanismRanges, corners, read_ranges

NOMINAL = PlantModel()


def test_corners_are_the_nominal_mechanism_and_all_signs_of_all_deviations():
    models = corners(NOMINAL, MechanismRanges())
    assert models[0] == NOMINAL
    assert len(set(models)) == len(models) == 17
    dampings = {model.structure.damping for model in models[1:]}
    assert sorted(dampings) == pytest.approx([0.8 * 36.9, 1.2 * 36.9])


def test_what_is_certain_makes_no_corners():
    assert corners(NOMINAL, MechanismRanges(0.0, 0.0, 0.0, 0.0)) == (NOMINAL,)
    assert len(corners(NOMINAL, MechanismRanges(0.0, 0.0, 0.0, 0.2))) == 3


def calibration(path, **changes):
    constants = {
        "motor.back_emf_constant": {"value": 0.1, "standard_uncertainty": 0.001},
        "stiffness_per_mass": {"value": 2000.0, "standard_uncertainty": 10.0},
        "damping_per_mass": {"value": 7.0, "standard_uncertainty": 0.35},
    } | changes
    path.write_text(json.dumps({"parameters": constants}), encoding="utf-8")
    return path


def test_a_calibration_gives_two_standard_uncertainties_to_either_side(tmp_path):
    ranges = read_ranges(calibration(tmp_path / "found.json"))
    assert ranges.back_emf == pytest.approx(0.02)
    assert (ranges.mass, ranges.stiffness) == (0.0, pytest.approx(0.01))
    assert ranges.damping == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"damping_per_mass": {}}, "tells no damping_per_mass"),
        (
            {"damping_per_mass": {"value": 7.0, "standard_uncertainty": 5.0}},
            "too unsure to design for: MechanismRanges.damping = 1.4",
        ),
        (
            {"damping_per_mass": {"value": -1.0, "standard_uncertainty": 0.1}},
            "must be positive and known",
        ),
    ],
)
def test_a_calibration_that_does_not_tell_enough_is_refused(tmp_path, changes, text):
    with pytest.raises(BadInputError, match=text):
        read_ranges(calibration(tmp_path / "found.json", **changes))


@pytest.mark.parametrize("text", ["", "[]", "{}"])
def test_what_is_no_calibration_is_refused(tmp_path, text):
    path = tmp_path / "found.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(BadInputError, match=r"is not JSON|must be what bdt calibrate"):
        read_ranges(path)


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(BadInputError, match="cannot be read"):
        read_ranges(tmp_path / "none.json")
