"""Matrix exponential in whole numbers, so that a model is the same to the last bit everywhere.

The libraries' own orders and fuses its sums as suits the processor. The last bits of coefficients
then differ from one computer to the next, and a loop with backlash makes more of them.
"""

import math
from collections.abc import Callable
from operator import add

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
Rows = list[list[int]]
Exponential = Callable[[FloatArray], FloatArray]
"""A function that returns the exponential of a matrix of shape (n, n)."""

BITS = 192
"""Binary places of the fixed-point numbers, beside those that squaring uses up."""

BITS_PER_SQUARING = 8
"""Binary places that a squaring may use up: one, and those of the largest element."""

MOST_BITS = 1100
"""Binary places before the point that no number has which is to become a float."""


def matrix_exponential(matrix: FloatArray) -> FloatArray:
    """Return exp(matrix), each element rounded once, to the nearest float.

    Parameters
    ----------
    matrix : ndarray, shape (n, n)
        Finite numbers: the matrix of a linear system times the sample time.

    Returns
    -------
    ndarray, shape (n, n)

    Raises
    ------
    OverflowError
        If an element is too large for a float, or the matrix is not finite.

    Notes
    -----
    The Taylor series of a fraction of the matrix, then squared (scaling and squaring), in
    fixed-point numbers whose error is far beyond the 53 bits of a float. Only elements that are
    some 1e-40 times the largest one have fewer good digits.

    References
    ----------
    C. Moler, C. Van Loan, Nineteen dubious ways to compute the exponential of a matrix,
    twenty-five years later, SIAM Review 45 (2003), method 3.
    """
    rows = np.asarray(matrix, dtype=np.float64).tolist()
    squarings = squarings_below_one(rows)
    places = BITS + BITS_PER_SQUARING * squarings
    fraction = [[_fixed_point(element, places - squarings) for element in row] for row in rows]
    power = _taylor_series(fraction, places)
    for _ in range(squarings):
        power = _product(power, power, places)
        if max(abs(element) for row in power for element in row) >> (places + MOST_BITS):
            raise OverflowError("the exponential of a matrix has elements too large for a float")
    # The quotient of two whole numbers is rounded correctly.
    return np.array([[element / (1 << places) for element in row] for row in power])


def squarings_below_one(rows: list[list[float]]) -> int:
    """Return how often a matrix has to be halved for its norm to be below one.

    Raises
    ------
    OverflowError
        If the matrix is not finite.
    """
    norm = max(math.fsum(map(abs, row)) for row in rows)
    if not math.isfinite(norm):
        raise OverflowError("the exponential of a matrix that is not finite")
    return max(math.frexp(norm)[1], 0)


def _taylor_series(matrix: Rows, places: int) -> Rows:
    """Return the exponential of a matrix whose norm is below one."""
    one = 1 << places
    term = [[one * (i == j) for j in range(len(matrix))] for i in range(len(matrix))]
    total, number = term, 0
    # Rounding downwards makes minus one of a negative element for ever.
    while max(map(max, term)) > 0 or min(map(min, term)) < -1:
        number += 1
        part = [[element // number for element in row] for row in matrix]
        term = _product(part, term, places)
        total = [list(map(add, *rows)) for rows in zip(total, term, strict=True)]
    return total


def _product(left: Rows, right: Rows, places: int) -> Rows:
    """Return the product of two matrices; many elements of the left one are zero."""
    product = []
    for row in left:
        sums = [0] * len(row)
        for factor, summands in zip(row, right, strict=True):
            if factor:
                sums = [s + factor * x for s, x in zip(sums, summands, strict=True)]
        product.append([s >> places for s in sums])
    return product


def _fixed_point(number: float, places: int) -> int:
    numerator, denominator = number.as_integer_ratio()
    return (numerator << places) // denominator
