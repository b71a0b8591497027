"""Sums, products and solutions against exact ones, and the order of their operations."""

import math
from fractions import Fraction

import numpy as np
import pytest

from bdt_twin.fixed_order import (
    dot,
    mean,
    product,
    products_of_rows,
    solution,
    standard_deviation,
    total,
    weighted_products,
)

RANDOM = np.random.default_rng(7)


def positive_definite(size):
    rows = RANDOM.normal(size=(size, 3 * size))
    return rows @ rows.T


def test_a_product_adds_from_the_first_column_to_the_last():
    matrix, vector = RANDOM.normal(size=(5, 40)), RANDOM.normal(size=40)
    expected = np.zeros(5)
    for column, factor in zip(matrix.T, vector, strict=True):
        expected += column * factor
    assert (product(matrix, vector) == expected).all()


@pytest.mark.parametrize("turned", [np.transpose, np.asfortranarray, lambda rows: rows[::2]])
def test_a_product_takes_a_matrix_as_it_lies_in_memory(turned):
    matrix = turned(RANDOM.normal(size=(8, 8)))
    vector = RANDOM.normal(size=matrix.shape[1])
    assert (product(matrix, vector) == product(np.ascontiguousarray(matrix), vector)).all()


def test_sums_are_right_but_for_rounding():
    left, right = RANDOM.normal(size=(2, 1000))
    exact = sum(
        Fraction(a) * Fraction(b) for a, b in zip(left.tolist(), right.tolist(), strict=True)
    )
    assert dot(left, right) == pytest.approx(float(exact), rel=1e-13)
    assert total(left) == pytest.approx(math.fsum(left.tolist()), rel=1e-13)
    assert mean(left) == pytest.approx(math.fsum(left.tolist()) / 1000, rel=1e-13)
    assert standard_deviation(left) == pytest.approx(np.std(left), rel=1e-13)


def test_products_of_rows_are_those_of_each_with_each():
    left, right = RANDOM.normal(size=(4, 300)), RANDOM.normal(size=(300, 7)).T
    left[2, :150] = 0.0
    assert products_of_rows(left, right) == pytest.approx(left @ right.T, abs=1e-11)
    assert products_of_rows(left, right)[1, 3] == dot(left[1], right[3].copy()), "in the same order"


def test_weighted_products_are_symmetric_and_those_of_all_pairs():
    rows, weights = RANDOM.normal(size=(6, 300)), RANDOM.uniform(0.5, 2.0, 300)
    rows[2, :150] = 0.0
    found = weighted_products(rows, weights)
    assert (found == found.T).all()
    assert found == pytest.approx((rows * weights) @ rows.T, abs=1e-11)


@pytest.mark.parametrize("size", [1, 2, 30])
def test_a_solution_solves(size):
    matrix, right = positive_definite(size), RANDOM.normal(size=(size, 3))
    expected = np.linalg.solve(matrix, right)
    assert solution(matrix, right) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_the_solution_for_the_unit_matrix_is_the_inverse():
    matrix = positive_definite(20)
    assert solution(matrix, np.eye(20)) @ matrix == pytest.approx(np.eye(20), abs=1e-11)


def test_unknowns_of_very_different_size_are_no_trouble():
    """Gaps in radians stand beside positions in meters: 1e12 times the information."""
    scale = np.logspace(-6.0, 6.0, 12)
    matrix = positive_definite(12)
    right = matrix @ np.ones((12, 1)) * scale[:, None]
    found = solution(matrix * np.outer(scale, scale), right)
    assert found * scale[:, None] == pytest.approx(np.ones((12, 1)), rel=1e-9)


def test_what_is_given_stays_as_it_is():
    matrix, right = positive_definite(4), np.ones((4, 1))
    copies = matrix.copy(), right.copy()
    solution(matrix, right)
    assert (matrix == copies[0]).all()
    assert (right == copies[1]).all()
