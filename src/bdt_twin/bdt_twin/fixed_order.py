"""Linear algebra in a fixed order of operations, the same to the last bit on every computer.

BLAS, LAPACK and numpy's einsum order and fuse their sums as suits the processor, and an estimate
that differs in its last bits commands a dead zone that does. These loops also wake no threads,
which on a busy computer wait for each other most of the time.
"""

import math
from functools import cache, reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import GIVEN, WRITTEN, compile_loop

FloatArray = NDArray[np.float64]

WRITTEN_MATRIX = "Array(float64, 2, 'C')"
"""Numba's type of an array of shape (m, n) that a loop writes."""


def product(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    """Return the product of a matrix of shape (m, n) and a vector of shape (n,)."""
    sums = np.zeros(len(matrix))
    # Where columns lie together they are added to all sums at once, each sum in the same order.
    if matrix.flags.fnc:
        compiled_sum_of_columns()(matrix.T, vector, sums)
    else:
        compiled_product()(matrix, vector, sums)
    return sums


def dot(left: FloatArray, right: FloatArray) -> float:
    """Return the scalar product of two vectors of shape (n,)."""
    return float(product(left[None, :], right)[0])


def total(values: FloatArray) -> float:
    """Return the sum of a vector of shape (n,)."""
    return dot(values, np.ones(values.size))


def mean(values: FloatArray) -> float:
    """Return the mean of a vector of shape (n,)."""
    return total(values) / values.size


def standard_deviation(values: FloatArray) -> float:
    """Return the standard deviation of a vector of shape (n,)."""
    deviations = values - mean(values)
    return math.sqrt(dot(deviations, deviations) / values.size)


def block_means(values: FloatArray, block: int) -> FloatArray:
    """Return the mean of each block of values, shape (blocks,)."""
    means: FloatArray = reduce(np.add, values.reshape(-1, block).T) / block
    return means


def weighted_products(rows: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the products of each row with each, summed with weights.

    Parameters
    ----------
    rows : ndarray, shape (m, n)
        The rows.
    weights : ndarray, shape (n,)
        Weight of each column.

    Returns
    -------
    ndarray, shape (m, m)
        Symmetric matrix.
    """
    products = np.zeros((len(rows), len(rows)))
    compiled_weighted_products()(np.ascontiguousarray(rows.T), weights, products)
    return products


def products_of_rows(left: FloatArray, right: FloatArray) -> FloatArray:
    """Return the products of each row of a matrix with each of another one.

    Parameters
    ----------
    left, right : ndarray, shape (m, n) and (k, n)
        The rows.

    Returns
    -------
    ndarray, shape (m, k)
    """
    sums = np.zeros((len(left), len(right)))
    columns = np.ascontiguousarray(left.T), np.ascontiguousarray(right.T)
    compiled_products_of_rows()(*columns, sums)
    return sums


def solution(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Return the solution of linear equations with a symmetric, positive definite matrix.

    Parameters
    ----------
    matrix : ndarray, shape (n, n)
        The matrix.
    right : ndarray, shape (n, m)
        Right sides of the equations.

    Returns
    -------
    ndarray, shape (n, m)
    """
    found = np.array(right, order="C")
    compiled_elimination()(np.array(matrix, order="C"), found)
    return found


@cache
def compiled_product() -> Any:
    """Return the loop of :func:`product`, compiled."""
    given = "Array(float64, 2, 'A', readonly=True)"
    return compile_loop(_multiply, f"void({given}, {GIVEN}, {WRITTEN})")


@cache
def compiled_sum_of_columns() -> Any:
    """Return the loop of :func:`product` for columns that lie together, compiled."""
    given = "Array(float64, 2, 'C', readonly=True)"
    return compile_loop(_add_columns, f"void({given}, {GIVEN}, {WRITTEN})")


@cache
def compiled_weighted_products() -> Any:
    """Return the loop of :func:`weighted_products`, compiled."""
    given = "Array(float64, 2, 'C', readonly=True)"
    return compile_loop(_add_weighted_products, f"void({given}, {GIVEN}, {WRITTEN_MATRIX})")


@cache
def compiled_products_of_rows() -> Any:
    """Return the loop of :func:`products_of_rows`, compiled."""
    given = "Array(float64, 2, 'C', readonly=True)"
    return compile_loop(_add_products_of_rows, f"void({given}, {given}, {WRITTEN_MATRIX})")


@cache
def compiled_elimination() -> Any:
    """Return the loop of :func:`solution`, compiled."""
    return compile_loop(_eliminate, f"void({WRITTEN_MATRIX}, {WRITTEN_MATRIX})")


COMPILED = (
    compiled_product,
    compiled_sum_of_columns,
    compiled_weighted_products,
    compiled_products_of_rows,
    compiled_elimination,
)
"""What to call before the first data wait."""


def _multiply(matrix: FloatArray, vector: FloatArray, sums: FloatArray) -> None:
    for row in range(sums.size):
        total = 0.0
        for column in range(vector.size):
            total += matrix[row, column] * vector[column]
        sums[row] = total


def _add_columns(columns: FloatArray, vector: FloatArray, sums: FloatArray) -> None:
    for column in range(vector.size):
        for row in range(sums.size):
            sums[row] += columns[column, row] * vector[column]


def _add_weighted_products(columns: FloatArray, weights: FloatArray, sums: FloatArray) -> None:
    for number in range(weights.size):
        for row in range(len(sums)):
            weighted = weights[number] * columns[number, row]
            # Many slopes are zero.
            if weighted != 0.0:
                for other in range(row + 1):
                    sums[row, other] += weighted * columns[number, other]
    for row in range(len(sums)):
        for other in range(row):
            sums[other, row] = sums[row, other]


def _add_products_of_rows(left: FloatArray, right: FloatArray, sums: FloatArray) -> None:
    for number in range(len(left)):
        for row in range(len(sums)):
            factor = left[number, row]
            # Many slopes are zero.
            if factor != 0.0:
                for other in range(sums.shape[1]):
                    sums[row, other] += factor * right[number, other]


def _eliminate(matrix: FloatArray, found: FloatArray) -> None:
    """Solve by Gauss's elimination, which needs no pivoting for a positive definite matrix."""
    count = len(matrix)
    for pivot in range(count):
        for row in range(pivot + 1, count):
            factor = matrix[row, pivot] / matrix[pivot, pivot]
            if factor != 0.0:
                for column in range(pivot, count):
                    matrix[row, column] -= factor * matrix[pivot, column]
                for column in range(found.shape[1]):
                    found[row, column] -= factor * found[pivot, column]
    for row in range(count - 1, -1, -1):
        for column in range(found.shape[1]):
            for later in range(row + 1, count):
                found[row, column] -= matrix[row, later] * found[later, column]
            found[row, column] /= matrix[row, row]
