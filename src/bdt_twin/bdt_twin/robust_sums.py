"""Sums over innovations that outliers hardly change, compiled, and in a fixed order.

A search for the levels of a machine's noise asks for them at each of its trials.
"""

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import GIVEN, compile_loop
from bdt_plant.elementary_functions import LOGARITHM_OF_TWO, float_logarithm

FloatArray = NDArray[np.float64]


def median(values: FloatArray) -> float:
    """Return the median of values, shape (n,), in half of the time that numpy takes for it."""
    half = values.size // 2
    ordered = np.partition(values, half)
    middle = float(ordered[half])
    return middle if values.size % 2 else 0.5 * (float(ordered[:half].max()) + middle)


def bounded_mean_square(values: FloatArray, bound: float) -> float:
    """Return the mean square of values, shape (n,), of which larger ones count as the bound."""
    return float(compiled_bounded_squares()(values, bound)) / values.size


def huber_loss(values: FloatArray, bound: float) -> float:
    """Return the sum of Huber's loss of values, shape (n,): linear beyond a bound.

    References
    ----------
    P. J. Huber, Robust Estimation of a Location Parameter, Annals of Mathematical Statistics 35
    (1964).
    """
    return float(compiled_losses()(values, bound))


def mean_logarithm(values: FloatArray) -> float:
    """Return the mean of the natural logarithms of positive values, shape (n,)."""
    mantissa, twos = compiled_product_of_all()(values)
    return (float_logarithm(float(mantissa)) + int(twos) * LOGARITHM_OF_TWO) / values.size


@cache
def compiled_bounded_squares() -> Any:
    """Return the loop of :func:`bounded_mean_square`, compiled."""
    return compile_loop(_bounded_squares, f"float64({GIVEN}, float64)")


@cache
def compiled_losses() -> Any:
    """Return the loop of :func:`huber_loss`, compiled."""
    return compile_loop(_losses, f"float64({GIVEN}, float64)")


@cache
def compiled_product_of_all() -> Any:
    """Return the loop of :func:`mean_logarithm`, compiled."""
    return compile_loop(_product_of_all, f"Tuple((float64, int64))({GIVEN})")


COMPILED = (compiled_bounded_squares, compiled_losses, compiled_product_of_all)
"""What to call before the first data wait."""


def _bounded_squares(values: FloatArray, bound: float) -> float:
    total = 0.0
    for number in range(values.size):
        bounded = max(min(values[number], bound), -bound)
        total += bounded * bounded
    return total


def _losses(values: FloatArray, bound: float) -> float:
    total = 0.0
    for number in range(values.size):
        size = abs(values[number])
        total += 0.5 * size * size if size <= bound else bound * (size - 0.5 * bound)
    return total


def _product_of_all(values: FloatArray) -> tuple[float, int]:
    """Return the product of positive values as a number and a power of two, which may be large."""
    product, twos = 1.0, 0
    for number in range(values.size):
        product *= values[number]
        if not 1e-150 < product < 1e150:
            product, more = math.frexp(product)
            twos += more
    return product, twos
