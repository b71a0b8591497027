"""Interpolated discrete models are the exact ones but for what no sensor sees."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bdt_plant.plant import PlantModel, discretize_plant
from bdt_plant.structure import discretize_structure
from bdt_twin.model_factors import block_model_with, model_with, plant_step_with

MODEL, SAMPLE_TIME = PlantModel(), 1e-3
small = st.floats(-0.2, 0.2)


def numbers_of(step):
    rows = [*step.motor, *step.structure, *step.contact]
    return np.array([number for row in rows for number in row])


def test_factors_multiply_the_gain_and_the_structure_per_mass():
    changed = model_with(MODEL, np.log([1.1, 1.2, 1.3]))
    assert changed.motor.back_emf_constant == pytest.approx(0.1 / 1.1)
    assert changed.structure.stiffness == pytest.approx(1.2e4)
    assert changed.structure.damping == pytest.approx(1.3 * 36.9)
    assert changed.structure.mass == MODEL.structure.mass


def test_without_factors_the_model_is_exact():
    assert plant_step_with(MODEL, np.zeros(3), SAMPLE_TIME) == discretize_plant(MODEL, SAMPLE_TIME)


@settings(max_examples=20, deadline=None)
@given(st.tuples(small, small, small))
def test_between_the_points_of_the_grid_the_model_is_nearly_exact(factors):
    logarithms = np.array(factors)
    step = plant_step_with(MODEL, logarithms, SAMPLE_TIME)
    exact = discretize_plant(model_with(MODEL, logarithms), SAMPLE_TIME)
    assert step.pitch == exact.pitch
    found, expected = numbers_of(step), numbers_of(exact)
    changed = np.abs(expected - numbers_of(discretize_plant(MODEL, SAMPLE_TIME)))
    # Some numbers are differences of others: what is left of rounding does not shrink with them.
    assert (np.abs(found - expected) < 2e-6 * changed + 1e-9 * np.abs(expected) + 1e-12).all()


@settings(max_examples=20, deadline=None)
@given(st.tuples(small, small, small))
def test_a_structure_follows_a_base_at_rest_exactly(factors):
    for row, place in zip(
        plant_step_with(MODEL, np.array(factors), SAMPLE_TIME).structure, (1, 0, 1, 0), strict=True
    ):
        assert row[0] + row[2] + row[4] + row[5] == pytest.approx(place, abs=1e-11)


def test_the_block_model_is_that_of_a_longer_sample():
    factors = np.log([1.1, 1.01, 0.9])
    structure = model_with(MODEL, factors).structure
    start, step = block_model_with(MODEL, factors, SAMPLE_TIME, 5)
    assert np.array(step) == pytest.approx(
        np.array(discretize_structure(structure, 5 * SAMPLE_TIME)), rel=1e-4, abs=1e-6
    )
    one_sample = np.array([row[:4] for row in discretize_structure(structure, SAMPLE_TIME)])
    powers = [np.linalg.matrix_power(one_sample, n) for n in range(5)]
    assert start == pytest.approx(np.mean(powers, axis=0), rel=1e-4, abs=1e-6)
