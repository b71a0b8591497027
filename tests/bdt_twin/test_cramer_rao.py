"""The bound against slopes taken from the plant's own simulation, and its laws."""

import math

import numpy as np
import pytest

from bdt_plant.plant import PlantModel
from bdt_twin.cramer_rao import cramer_rao_bound, fisher_information
from bdt_twin.machine_knowledge import EFFECTS
from bdt_twin.model_factors import FACTORS
from bdt_twin.stretch import Stretch
from bdt_twin.unknowns import INITIAL_CONDITION, Unknowns
from bdt_twin.window_model import WindowModel

RATE, BLOCK, NOISE, TIME = 1000.0, 5, 5e-6, 9.5
KNOTS = np.arange(0.0, 12.1, 2.0)


def window_of(rows):
    stretch = Stretch(0, *np.ascontiguousarray(rows[:, 1:].T))
    return WindowModel(PlantModel(), [stretch], KNOTS, RATE, BLOCK)


def truth(degrees=10.0):
    """Return the unknowns of a loop that begins at rest, or nearly: slopes have two sides there."""
    gaps = np.full(KNOTS.size, math.radians(degrees))
    initial_conditions = np.zeros((1, len(INITIAL_CONDITION)))
    initial_conditions[0, 0] = 0.01
    return Unknowns(gaps, np.zeros(len(FACTORS)), initial_conditions)


def test_the_bound_is_that_of_all_samples_and_slopes_by_differences(closed_loop):
    window, unknowns = window_of(closed_loop().rows), truth()
    vector, jacobian = unknowns.as_vector(), []
    effects = KNOTS.size + len(FACTORS) + np.arange(len(EFFECTS))
    directions = np.delete(np.eye(vector.size), [*range(KNOTS.size), *effects], axis=0)
    level, growth = np.zeros((2, vector.size))
    level[: KNOTS.size], growth[: KNOTS.size] = 1.0, KNOTS - TIME
    for direction in [level, growth, *directions]:
        ahead, behind = (
            window.simulate(unknowns.from_vector(vector + change * direction))[0].position
            for change in (1e-5, -1e-5)
        )
        jacobian.append((ahead - behind) / 2e-5)
    # The gap is what is left of its slope beside all other slopes.
    others = np.array(jacobian[1:]).T
    others /= np.linalg.norm(others, axis=0)
    left = jacobian[0] - others @ np.linalg.lstsq(others, jacobian[0], rcond=None)[0]
    expected = NOISE / np.linalg.norm(left)
    assert cramer_rao_bound(window, unknowns, TIME, NOISE) == pytest.approx(expected, rel=0.05)


def test_information_is_the_sum_over_all_measurements():
    random = np.random.default_rng(5)
    jacobian, weights = random.normal(size=(9, 300)), random.uniform(0.5, 2.0, 300)
    for row, begin in zip(jacobian, [0, 250, 299, 300, 10, 0, 120, 121, 120], strict=True):
        row[:begin] = 0.0
    expected = (jacobian * weights) @ jacobian.T
    assert fisher_information(jacobian, weights) == pytest.approx(expected, abs=1e-10)


def test_the_bound_grows_with_the_noise(closed_loop):
    window, unknowns = window_of(closed_loop().rows), truth()
    one, two = (cramer_rao_bound(window, unknowns, TIME, noise) for noise in (NOISE, 2 * NOISE))
    assert two == pytest.approx(2 * one)


def test_less_data_tell_less(closed_loop):
    rows, unknowns = closed_loop().rows, truth()
    all_of_them = cramer_rao_bound(window_of(rows), unknowns, TIME, NOISE)
    half = cramer_rao_bound(window_of(rows[:6000]), unknowns, TIME, NOISE)
    assert half > 1.5 * all_of_them


def test_a_motor_at_rest_tells_nothing():
    bound = cramer_rao_bound(window_of(np.zeros((12000, 3))), truth(), TIME, NOISE)
    assert bound == math.inf


def test_without_a_reversal_the_gap_is_nearly_unknown(closed_loop):
    rows = np.zeros((12000, 3))
    rows[:, 1] = 1.0
    with_reversals = cramer_rao_bound(window_of(closed_loop().rows), truth(), TIME, NOISE)
    assert cramer_rao_bound(window_of(rows), truth(), TIME, NOISE) > 50 * with_reversals


def test_information_is_the_weighted_product_of_slopes():
    jacobian, weights = np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([10.0, 100.0])
    assert fisher_information(jacobian, weights).tolist() == [[410.0, 830.0], [830.0, 1690.0]]
