"""Exponential function, logarithm, power and sine, the same to the last bit on every computer.

Those of C libraries and of numpy differ in their last bits, also from processor to processor.
These consist of the operations whose rounding IEEE 754 prescribes, in a fixed order.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]

LOGARITHM_OF_TWO = 0.6931471805599453
HIGH_PART, LOW_PART = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""The same in two parts, of which the high one times a whole number is exact."""
PER_LOGARITHM_OF_TWO = 1.0 / LOGARITHM_OF_TWO
FULL_TURN = 6.283185307179586
EXPONENTIAL_SERIES = tuple(1.0 / math.factorial(order) for order in range(13, -1, -1))
"""Coefficients of Taylor's series of the exponential function, the last ones first."""
SMALL_EXPONENT = 1e-3
"""Size of a negative exponent below which a few terms of the series are enough."""
SMALLEST_EXPONENT = 700.0
"""Size of a negative exponent from which on the power of e counts as nothing."""
ROOT_OF_A_HALF = 0.7071067811865476
LARGEST_LOGARITHM = 800.0
"""Size of a logarithm from which on the number is no float."""


def exponential(number: ArrayLike) -> FloatArray:
    """Return exp(number), right to 2 units in the last place."""
    limited = np.clip(number, -LARGEST_LOGARITHM, LARGEST_LOGARITHM)
    twos = np.rint(limited / LOGARITHM_OF_TWO)
    # At most 0.35: the next term of Taylor's series is below 1e-17.
    rest, series = (limited - twos * HIGH_PART) - twos * LOW_PART, np.ones_like(limited)
    for order in range(13, 0, -1):
        series = 1.0 + series * rest / order
    return np.asarray(np.ldexp(series, twos.astype(np.int64)))


def logarithm(number: ArrayLike) -> FloatArray:
    """Return the natural logarithm of positive numbers, right to 3 units in the last place."""
    mantissa, twos = np.frexp(number)
    low = mantissa < ROOT_OF_A_HALF
    mantissa, twos = np.where(low, 2.0 * mantissa, mantissa), twos - low
    # Twice the area hyperbolic tangent of a ratio below 0.172: the next term is below 1e-17.
    ratio = (mantissa - 1.0) / (mantissa + 1.0)
    squared, series = ratio * ratio, np.zeros_like(ratio)
    for order in range(19, 0, -2):
        series = series * squared + 2.0 / order
    return np.asarray(twos * HIGH_PART + (twos * LOW_PART + ratio * series))


def float_exponential(number: float) -> float:
    """Return :func:`exponential` of a float, to the last bit, in a tenth of the time."""
    if math.isnan(number):
        return number
    limited = min(max(number, -LARGEST_LOGARITHM), LARGEST_LOGARITHM)
    twos = float(round(limited / LOGARITHM_OF_TWO))
    rest, series = (limited - twos * HIGH_PART) - twos * LOW_PART, 1.0
    for order in range(13, 0, -1):
        series = 1.0 + series * rest / order
    try:
        return math.ldexp(series, int(twos))
    except OverflowError:
        return math.inf


def float_logarithm(number: float) -> float:
    """Return :func:`logarithm` of a positive float, to the last bit, in a tenth of the time."""
    mantissa, twos = math.frexp(number)
    if mantissa < ROOT_OF_A_HALF:
        mantissa, twos = 2.0 * mantissa, twos - 1
    ratio = (mantissa - 1.0) / (mantissa + 1.0)
    squared, series = ratio * ratio, 0.0
    for order in range(19, 0, -2):
        series = series * squared + 2.0 / order
    return twos * HIGH_PART + (twos * LOW_PART + ratio * series)


def power(base: FloatArray, exponent: float) -> FloatArray:
    """Return numbers from 0 to 1 raised to a power, right to 1e-15.

    Parameters
    ----------
    base : ndarray
        The numbers.
    exponent : float
        The exponent, positive. Whole ones need no logarithm.
    """
    product, square, whole = np.ones_like(base), base, int(exponent)
    while whole:
        if whole % 2:
            product = product * square
        square, whole = square * square, whole // 2
    part = exponent % 1.0
    if not part:
        return product
    positive = np.where(base > 0.0, base, 1.0)
    return np.where(base > 0.0, product * exponential(part * logarithm(positive)), 0.0)


def sine_of_turns(turns: float) -> float:
    """Return sin(2 pi turns), right to 1e-15; a step function on floats."""
    part = turns - math.floor(turns + 0.5)
    if part > 0.25:
        part = 0.5 - part
    elif part < -0.25:
        part = -0.5 - part
    angle = FULL_TURN * part
    square, series = angle * angle, 1.0
    # At most a quarter of a turn: the next term of Taylor's series is below 1e-17.
    for order in range(20, 1, -2):
        series = 1.0 - series * square / (order * (order + 1))
    return angle * series


def decaying_exponential(number: float) -> float:
    """Return exp(number) of a number that is not positive, right to 1e-15; a step function."""
    if number < -SMALLEST_EXPONENT:
        return 0.0
    if number > -SMALL_EXPONENT:
        # The next term of the series is below 1e-17.
        return 1.0 + number * (1.0 + number * (0.5 + number * (1.0 / 6.0 + number / 24.0)))
    twos = math.floor(number * PER_LOGARITHM_OF_TWO + 0.5)
    rest, series = (number - twos * HIGH_PART) - twos * LOW_PART, 0.0
    for coefficient in EXPONENTIAL_SERIES:
        series = coefficient + series * rest
    return series if twos == 0 else math.ldexp(series, int(twos))
