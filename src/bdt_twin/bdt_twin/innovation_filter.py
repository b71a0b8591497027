"""The recursions of the filter of :mod:`bdt_twin.innovations`, compiled.

The state is that of the structure (q2, its velocity, q3, its velocity), the screw and the motor,
all as deviations of the machine from its model.
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import GIVEN, WRITTEN, compile_loop

FloatArray = NDArray[np.float64]

STATES = 6
"""Structure, screw and motor."""
LARGEST_PUSH = 0.1
"""Standard deviation of the velocity that a push gives to a platform [m/s]."""
SMALLEST_PUSH = 1e-7
"""Innovation below which nothing pushed a platform, however little noise there is [m]."""


@cache
def compiled_gains() -> Any:
    """Return the recursion of the filter's covariance, compiled."""
    matrix = "Array(float64, 2, 'C', readonly=True)"
    return compile_loop(
        _filter_gains,
        f"void({matrix}, {GIVEN}, {GIVEN}, {GIVEN}, {GIVEN}, float64, float64, float64, "
        f"Array(float64, 2, 'C'), {WRITTEN}, {WRITTEN}, {WRITTEN})",
    )


@cache
def compiled_innovations() -> Any:
    """Return the filter itself, compiled."""
    matrix = "Array(float64, 2, 'C', readonly=True)"
    return compile_loop(
        _innovations,
        f"void({matrix}, {GIVEN}, {GIVEN}, {matrix}, Array(float64, 2, 'A', readonly=True), "
        "Array(float64, 2, 'C'))",
    )


def _filter_gains(  # noqa: PLR0912 - a compiled loop calls no function
    step: FloatArray,
    begins: FloatArray,
    contact: FloatArray,
    walk: FloatArray,
    residual: FloatArray,
    force: float,
    reading: float,
    threshold: float,
    gains: FloatArray,
    variances: FloatArray,
    pushed: FloatArray,
    innovations: FloatArray,
) -> None:
    state, expected = np.zeros(6), np.zeros(6)
    covariance, moved = np.zeros((6, 6)), np.zeros((6, 6))
    transition, transposed = np.zeros((6, 6)), np.zeros((6, 6))
    for i in range(4):
        for j in range(4):
            transition[i, j] = step[i, j]
            transposed[j, i] = step[i, j]
    transition[5, 5] = 1.0
    transposed[5, 5] = 1.0
    for k in range(walk.size):
        if begins[k] > 0.0:
            covariance[:] = 0.0
            expected[:] = 0.0
        else:
            held = 1.0 - contact[k]
            for i in range(4):
                transition[i, 4] = step[i, 4] + step[i, 5] * held
                transition[i, 5] = step[i, 5] * contact[k]
                transposed[4, i], transposed[5, i] = transition[i, 4], transition[i, 5]
            transition[4, 4], transition[4, 5] = held, contact[k]
            transposed[4, 4], transposed[5, 4] = held, contact[k]
            # Sums over whole rows, which the processor works on at once.
            moved[:] = 0.0
            for i in range(6):
                for n in range(6):
                    factor = transition[i, n]
                    if factor != 0.0:
                        for j in range(6):
                            moved[i, j] += factor * covariance[n, j]
            covariance[:] = 0.0
            for i in range(6):
                for n in range(6):
                    # The motor's walk acts as the motor's own column does.
                    factor = moved[i, n]
                    if n == 5:
                        factor += transition[i, 5] * walk[k]
                    for j in range(6):
                        covariance[i, j] += factor * transposed[n, j]
            covariance[1, 1] += force
            covariance[3, 3] += force
            for i in range(6):
                total = 0.0
                for n in range(6):
                    total += transition[i, n] * state[n]
                expected[i] = total
        innovation = residual[k] - expected[2]
        variance = max(covariance[2, 2], 0.0) + reading
        if innovation * innovation > max(threshold * threshold * variance, SMALLEST_PUSH**2):
            pushed[k] = 1.0
            for i in range(4):
                for j in range(4):
                    covariance[i, j] += LARGEST_PUSH**2 * (
                        step[i, 1] * step[j, 1] + step[i, 3] * step[j, 3]
                    )
            variance = covariance[2, 2] + reading
        variances[k], innovations[k] = variance, innovation
        for i in range(6):
            gains[k, i] = covariance[i, 2] / variance
            state[i] = expected[i] + gains[k, i] * innovation
        for i in range(6):
            factor = gains[k, i] * variance
            for j in range(i + 1):
                left = covariance[i, j] - factor * gains[k, j]
                covariance[i, j] = left
                covariance[j, i] = left
        for i in range(6):
            # Rounding may leave less than nothing where next to nothing is unknown.
            covariance[i, i] = max(covariance[i, i], 0.0)


def _innovations(
    step: FloatArray,
    begins: FloatArray,
    contact: FloatArray,
    gains: FloatArray,
    rows: FloatArray,
    found: FloatArray,
) -> None:
    for row in range(len(rows)):
        x0, x1, x2, x3, b, m = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(begins.size):
            if begins[k] > 0.0:
                x0, x1, x2, x3, b, m = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            else:
                after = m if contact[k] > 0.0 else b
                y0 = step[0, 0] * x0 + step[0, 1] * x1 + step[0, 2] * x2 + step[0, 3] * x3
                y1 = step[1, 0] * x0 + step[1, 1] * x1 + step[1, 2] * x2 + step[1, 3] * x3
                y2 = step[2, 0] * x0 + step[2, 1] * x1 + step[2, 2] * x2 + step[2, 3] * x3
                y3 = step[3, 0] * x0 + step[3, 1] * x1 + step[3, 2] * x2 + step[3, 3] * x3
                x0 = y0 + step[0, 4] * b + step[0, 5] * after
                x1 = y1 + step[1, 4] * b + step[1, 5] * after
                x2 = y2 + step[2, 4] * b + step[2, 5] * after
                x3 = y3 + step[3, 4] * b + step[3, 5] * after
                b = after
            innovation = rows[row, k] - x2
            found[row, k] = innovation
            x0 += gains[k, 0] * innovation
            x1 += gains[k, 1] * innovation
            x2 += gains[k, 2] * innovation
            x3 += gains[k, 3] * innovation
            b += gains[k, 4] * innovation
            m += gains[k, 5] * innovation
