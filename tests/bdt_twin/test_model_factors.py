"""Interpolated discrete models are the exact ones but for what no sensor sees."""

import numpy as np
import pytest

from bdt_plant.plant import PlantModel, discretize_plant
from bdt_plant.structure import StructureParameters, discretize_structure
from bdt_twin.model_factors import (
    block_model_with,
    check_room,
    model_with,
    motor_step_with,
    plant_step_with,
)

MODEL, SAMPLE_TIME = PlantModel(), 1e-3
POINTS = [
    (0.05, 0.01, -0.03),
    (0.0, 0.0, 0.125),
    (0.129, 0.0, 0.0),
    (-0.05, 0.107, -0.213),
    (0.0, 0.0, 0.0, 0.01),
    (0.05, 0.107, -0.213, 0.27),
    (0.05, 0.107, -0.213, -0.31),
]


def numbers_of(step):
    rows = [*step.motor, *step.structure, *step.contact]
    return np.array([number for row in rows for number in row])


def test_factors_multiply_the_gain_and_the_structure_per_mass():
    changed = model_with(MODEL, np.log([1.1, 1.2, 1.3]))
    assert changed.motor.back_emf_constant == pytest.approx(0.1 / 1.1)
    assert changed.structure.stiffness == pytest.approx(1.2e4)
    assert changed.structure.damping == pytest.approx(1.3 * 36.9)
    assert changed.structure.mass == MODEL.structure.mass


def test_a_machine_carries_what_it_is_said_to_unless_a_factor_tells_otherwise():
    laden = PlantModel(structure=StructureParameters(top_mass_ratio=1.5))
    assert model_with(laden, np.zeros(3)) == laden
    changed = model_with(laden, np.log([1.0, 1.0, 1.0, 1.2]))
    assert changed.structure == StructureParameters(top_mass_ratio=1.5 * 1.2)


def test_a_constant_that_could_not_be_corrected_is_refused():
    check_room(MODEL)
    for ratio, factor in ((0.015, "0.5"), (40.0, "3")):
        far = PlantModel(structure=StructureParameters(top_mass_ratio=ratio))
        with pytest.raises(ValueError, match=rf"top_mass_ratio.*also {factor} times as large"):
            check_room(far)


def test_without_factors_the_model_is_as_exact_as_floats_are():
    found = numbers_of(plant_step_with(MODEL, np.zeros(3), SAMPLE_TIME))
    exact = numbers_of(discretize_plant(MODEL, SAMPLE_TIME))
    assert np.abs(found - exact).max() < 1e-13 * np.abs(exact).max()


@pytest.mark.parametrize("factors", POINTS)
def test_between_the_points_of_the_grid_the_model_is_nearly_exact(factors):
    def exact(logarithms):
        return numbers_of(discretize_plant(model_with(MODEL, logarithms), SAMPLE_TIME))

    logarithms = np.array(factors)
    found = plant_step_with(MODEL, logarithms, SAMPLE_TIME)
    assert found.pitch == MODEL.lead_screw.pitch
    slopes = sum(
        np.abs(exact(logarithms + 1e-3 * axis) - exact(logarithms - 1e-3 * axis)) / 2e-3
        for axis in np.eye(logarithms.size)
    )
    assert slopes.max() > 1.0
    assert (np.abs(numbers_of(found) - exact(logarithms)) < 5e-5 * slopes + 1e-9).all()


@pytest.mark.parametrize("factors", POINTS)
def test_the_motor_alone_is_that_of_the_plant(factors):
    motor = motor_step_with(MODEL, np.array(factors), SAMPLE_TIME)
    expected = plant_step_with(MODEL, np.array(factors), SAMPLE_TIME).motor
    assert np.array(motor) == pytest.approx(np.array(expected), rel=1e-12)


@pytest.mark.parametrize("factors", POINTS)
def test_a_structure_follows_a_base_at_rest_exactly(factors):
    rows = plant_step_with(MODEL, np.array(factors), SAMPLE_TIME).structure
    for row, place in zip(rows, (1, 0, 1, 0), strict=True):
        assert row[0] + row[2] + row[4] + row[5] == pytest.approx(place, abs=1e-11)


def test_the_block_model_is_that_of_a_longer_sample():
    factors = np.log([1.1, 1.01, 0.9])
    structure = model_with(MODEL, factors).structure
    start, step = block_model_with(MODEL, factors, SAMPLE_TIME, 5)
    assert np.array(step) == pytest.approx(
        np.array(discretize_structure(structure, 5 * SAMPLE_TIME)), rel=1e-4, abs=1e-4
    )
    one_sample = np.array([row[:4] for row in discretize_structure(structure, SAMPLE_TIME)])
    powers = [np.linalg.matrix_power(one_sample, n) for n in range(5)]
    assert start == pytest.approx(np.mean(powers, axis=0), rel=1e-4, abs=1e-6)
