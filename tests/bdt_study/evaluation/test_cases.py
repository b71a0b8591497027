"""Random scenarios: the same for the same seed, and as wrong as the case says."""

import numpy as np
import pytest

from bdt_plant.gap_profile import gaps_at
from bdt_plant.plant import PlantModel
from bdt_study.evaluation.cases import CASES, draw_scenario
from bdt_study.evaluation.machine_effects import NO_EFFECTS

BY_NAME = {case.name: case for case in CASES}
with_each_case = pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)


def test_the_rows_of_the_issue_are_there_and_names_are_unique():
    assert {"clean", "laboratory", "harsh"} <= set(BY_NAME)
    assert len(BY_NAME) == len(CASES)


@with_each_case
def test_a_seed_means_one_scenario(case):
    assert repr(draw_scenario(case, 3)) == repr(draw_scenario(case, 3))
    assert repr(draw_scenario(case, 3)) != repr(draw_scenario(case, 4))


@pytest.mark.parametrize(
    "case", [case for case in CASES if case.effects == NO_EFFECTS], ids=lambda case: case.name
)
def test_plant_and_sensor_are_as_wrong_as_the_case_says(case):
    nominal = PlantModel()
    for seed in range(4):
        scenario = draw_scenario(case, seed)
        model = scenario.model
        gain = model.motor.back_emf_constant / nominal.motor.back_emf_constant
        assert abs(gain - 1.0) == pytest.approx(case.gain_error)
        for name, error in (
            ("mass", case.mechanics_error),
            ("stiffness", case.mechanics_error),
            ("damping", case.damping_error),
        ):
            ratio = getattr(model.structure, name) / getattr(nominal.structure, name)
            assert abs(ratio - 1.0) == pytest.approx(error)
        assert scenario.sensor.noise == case.noise
        assert scenario.sensor.quantization == case.quantization
        assert scenario.actuator.limit == (case.voltage_limit or np.inf)
        assert model.is_piecewise_linear


@with_each_case
def test_gaps_wear_out_and_do_not_heal(case):
    for seed in range(4):
        scenario = draw_scenario(case, seed)
        gaps = gaps_at(scenario.gap, np.linspace(0.0, scenario.duration, 200))
        assert np.diff(gaps).min() >= 0.0
        assert np.deg2rad(15.0) <= gaps[-1] <= np.deg2rad(30.0)
        assert not case.gap or scenario.gap.kind == case.gap


def test_both_signs_occur():
    models = [draw_scenario(BY_NAME["harsh"], seed).model for seed in range(8)]
    gains = {round(model.motor.back_emf_constant, 6) for model in models}
    assert gains == {0.095, 0.105}


def test_a_reading_is_off_by_noise_and_rounding():
    harsh = BY_NAME["harsh"]
    assert harsh.reading_error == pytest.approx(np.sqrt(25e-12 + 1e-12 / 12.0))
    assert [case.name for case in CASES if case.is_exact] == ["clean", "exact_model"]
