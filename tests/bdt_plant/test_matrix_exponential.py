"""The matrix exponential against exact sums, eigenvalues in many digits, and scipy's."""

import math
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import expm

from bdt_plant.matrix_exponential import matrix_exponential
from bdt_plant.motor import MotorParameters, motor_state_space
from bdt_plant.structure import StructureParameters, structure_state_space

SAMPLE_TIME = 2e-4


def exact_sum(matrix, terms):
    """Return so many terms of the Taylor series, rounded once."""
    exact = np.vectorize(Fraction, otypes=[object])(matrix)
    term = total = np.vectorize(Fraction, otypes=[object])(np.eye(len(matrix)))
    for number in range(1, terms):
        term = exact @ term / number
        total = total + term
    return total.astype(np.float64)


@pytest.mark.parametrize(
    "matrix",
    [motor_state_space(MotorParameters())[0], structure_state_space(StructureParameters())[0]],
    ids=["motor", "structure"],
)
def test_every_element_is_the_float_nearest_to_the_exact_one(matrix):
    matrix = matrix * SAMPLE_TIME
    # The norm is 32 at most: what is left out is below 32^160 / 160!, or 1e-43.
    assert (matrix_exponential(matrix) == exact_sum(matrix, 160)).all()


@given(st.floats(-120.0, 700.0))
def test_the_exponential_of_a_number_is_the_float_nearest_to_the_exact_one(number):
    with localcontext(prec=50):
        expected = float(Decimal(number).exp())
    assert matrix_exponential(np.array([[number]])) == expected


def by_eigenvalues(matrix):
    """Return the exponential of a matrix of shape (2, 2) with real eigenvalues (Sylvester)."""
    with localcontext(prec=80):
        (a, b), (c, d) = ([Decimal(x) for x in row] for row in matrix.tolist())
        root = ((a - d) ** 2 + 4 * b * c).sqrt()
        low, high = (a + d - root) / 2, (a + d + root) / 2
        first, second = low.exp() / (low - high), high.exp() / (high - low)
        shifted = ((a - high, b), (c, d - high)), ((a - low, b), (c, d - low))
        return np.array(
            [
                [float(first * shifted[0][i][j] + second * shifted[1][i][j]) for j in (0, 1)]
                for i in (0, 1)
            ]
        )


@pytest.mark.parametrize("inductance", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("sample_time", [1e-5, 2e-4, 1e-2, 1.0])
def test_a_stiff_motor_loses_no_digit(inductance, sample_time):
    a, _ = motor_state_space(MotorParameters(inductance=inductance))
    matrix = a[:2, :2] * sample_time
    found, expected = matrix_exponential(matrix), by_eigenvalues(matrix)
    # An element that has died away may be zero.
    np.testing.assert_allclose(found, expected, rtol=2e-16, atol=1e-60)


@given(arrays(np.float64, (4, 4), elements=st.floats(-3.0, 3.0)))
def test_any_matrix_of_moderate_size_has_scipy_s_exponential(matrix):
    found, expected = matrix_exponential(matrix), expm(matrix)
    # Of the matrix of twos, whose exponential is known, scipy's own is 1e-12 off and ours is not.
    assert np.abs(found - expected).max() <= 1e-11 * max(1.0, np.abs(expected).max())


def test_a_double_integrator_is_a_parabola():
    found = matrix_exponential(np.array([[0.0, 0.1, 0.0], [0.0, 0.0, 0.1], [0.0, 0.0, 0.0]]))
    assert found.tolist() == [[1.0, 0.1, 0.005000000000000001], [0.0, 1.0, 0.1], [0.0, 0.0, 1.0]]


def test_nothing_happens_in_no_time():
    assert (matrix_exponential(np.zeros((3, 3))) == np.eye(3)).all()


@pytest.mark.parametrize("growth", [710.0, 1e15])
def test_a_system_that_grows_beyond_all_floats_is_refused(growth):
    with pytest.raises(OverflowError, match="too large for a float"):
        matrix_exponential(np.array([[growth, 0.0], [0.0, -1.0]]))


@pytest.mark.parametrize("number", [math.nan, math.inf])
def test_a_matrix_that_is_not_finite_is_refused(number):
    with pytest.raises(OverflowError, match="not finite"):
        matrix_exponential(np.array([[0.0, number], [0.0, 0.0]]))
