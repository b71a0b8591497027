"""Matrix exponential in floats, for models that are made anew many times in a second.

It is the same to the last bit on every computer, as the one in whole numbers is, takes hundredths
of its time, and is rounded at each of its steps.
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import compile_loop
from bdt_plant.matrix_exponential import squarings_below_one

FloatArray = NDArray[np.float64]

TERMS = 14
"""Terms of the Taylor series, which for a norm below a half leave out less than a rounding does."""


def quick_exponential(matrix: FloatArray) -> FloatArray:
    """Return exp(matrix) by scaling and squaring, with sums in a fixed order.

    Parameters
    ----------
    matrix : ndarray, shape (n, n)
        Finite numbers: the matrix of a linear system times the sample time.

    Returns
    -------
    ndarray, shape (n, n)
        Off by some 1e-15 of the largest elements, and for each doubling of the norm up to twice
        that.

    Raises
    ------
    OverflowError
        If the matrix is not finite.

    References
    ----------
    C. Moler, C. Van Loan, Nineteen dubious ways to compute the exponential of a matrix,
    twenty-five years later, SIAM Review 45 (2003), method 3.
    """
    # The series is cut short for a norm below a half: twice the matrix is below one.
    squarings = squarings_below_one((2.0 * matrix).tolist())
    power = np.eye(len(matrix))
    compiled_powers()(np.ascontiguousarray(matrix) * 0.5**squarings, squarings, power)
    return power


@cache
def compiled_powers() -> Any:
    """Return the loops of :func:`quick_exponential`, compiled."""
    given, written = "Array(float64, 2, 'C', readonly=True)", "Array(float64, 2, 'C')"
    return compile_loop(_raise, f"void({given}, int64, {written})")


def _raise(matrix: FloatArray, squarings: int, power: FloatArray) -> None:
    """Make the exponential of a matrix, squared so many times, of the unit matrix."""
    count = len(matrix)
    product = np.empty((count, count))
    for step in range(TERMS + squarings):
        # Horner's scheme from the last term of the series to the first, then the squares.
        number = TERMS - step
        for row in range(count):
            for column in range(count):
                total = 0.0
                for other in range(count):
                    left = matrix[row, other] if number > 0 else power[row, other]
                    total += left * power[other, column]
                if number > 0:
                    total /= number
                    if row == column:
                        total += 1.0
                product[row, column] = total
        power[:] = product
