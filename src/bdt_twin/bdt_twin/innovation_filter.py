"""The recursions of the filter of :mod:`bdt_twin.innovations`, compiled.

The state is that of the structure (q2, its velocity, q3, its velocity), the screw and the motor,
all as deviations of the machine from its model.
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_plant.compilation import GIVEN, WRITTEN, compile_loop, compile_with_steps

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
    signature = (
        f"void({matrix}, {GIVEN}, {GIVEN}, {GIVEN}, {GIVEN}, float64, float64, float64, "
        f"Array(float64, 2, 'C'), {WRITTEN}, {WRITTEN}, {WRITTEN})"
    )
    return compile_with_steps(_gains_loop, [followed], lambda: signature)


@cache
def compiled_innovations() -> Any:
    """Return the filter itself, compiled."""
    matrix = "Array(float64, 2, 'C', readonly=True)"
    return compile_loop(
        _innovations,
        f"void({matrix}, {GIVEN}, {GIVEN}, {matrix}, {matrix}, Array(float64, 2, 'C'))",
    )


COMPILED = (compiled_gains, compiled_innovations)
"""What to call before the first data wait."""


def _gains_loop(sources: str) -> Any:
    def filter_gains(  # noqa: PLR0912 - one loop, compiled as a whole
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
        _ = sources
        state, expected = np.zeros(6), np.zeros(6)
        covariance, moved = np.zeros((6, 6)), np.zeros((4, 6))
        # How the structure follows all six; screw and motor follow the motor, or stay.
        follows = step.copy()
        for k in range(walk.size):
            if begins[k] > 0.0:
                covariance[:] = 0.0
                expected[:] = 0.0
            else:
                screw = 5 if contact[k] > 0.0 else 4
                for i in range(4):
                    follows[i, 4] = step[i, 4] if screw == 5 else step[i, 4] + step[i, 5]
                    follows[i, 5] = step[i, 5] if screw == 5 else 0.0
                # The motor walks before it moves the screw.
                covariance[5, 5] += walk[k]
                # A row is there before any of it is kept: so the processor adds side by side.
                for i in range(4):
                    moved[i, 0], moved[i, 1], moved[i, 2], moved[i, 3], moved[i, 4], moved[i, 5] = (
                        followed(covariance, 0, follows, i),
                        followed(covariance, 1, follows, i),
                        followed(covariance, 2, follows, i),
                        followed(covariance, 3, follows, i),
                        followed(covariance, 4, follows, i),
                        followed(covariance, 5, follows, i),
                    )
                for i in range(4):
                    for j in range(i + 1):
                        both = (
                            moved[i, 0] * follows[j, 0]
                            + moved[i, 1] * follows[j, 1]
                            + moved[i, 2] * follows[j, 2]
                            + moved[i, 3] * follows[j, 3]
                            + moved[i, 4] * follows[j, 4]
                            + moved[i, 5] * follows[j, 5]
                        )
                        covariance[i, j] = both
                        covariance[j, i] = both
                    covariance[i, 4] = moved[i, screw]
                    covariance[4, i] = moved[i, screw]
                    covariance[i, 5] = moved[i, 5]
                    covariance[5, i] = moved[i, 5]
                covariance[4, 4] = covariance[screw, screw]
                covariance[4, 5] = covariance[screw, 5]
                covariance[5, 4] = covariance[screw, 5]
                covariance[1, 1] += force
                covariance[3, 3] += force
                for i in range(4):
                    total = 0.0
                    for n in range(6):
                        total += follows[i, n] * state[n]
                    expected[i] = total
                expected[4], expected[5] = state[screw], state[5]
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

    return filter_gains


def followed(covariance: FloatArray, state: int, follows: FloatArray, row: int) -> float:
    """Return the covariance of what follows all states with one of them; a step function.

    Parameters
    ----------
    covariance : ndarray, shape (6, 6)
        That of the states.
    state : int
        Which state.
    follows : ndarray, shape (m, 6)
        How each row follows the states.
    row : int
        Which row.
    """
    total: float = (
        follows[row, 0] * covariance[0, state]
        + follows[row, 1] * covariance[1, state]
        + follows[row, 2] * covariance[2, state]
        + follows[row, 3] * covariance[3, state]
        + follows[row, 4] * covariance[4, state]
        + follows[row, 5] * covariance[5, state]
    )
    return total


def _innovations(
    step: FloatArray,
    begins: FloatArray,
    contact: FloatArray,
    gains: FloatArray,
    columns: FloatArray,
    found: FloatArray,
) -> None:
    count = columns.shape[1]
    state, follows = np.zeros((6, count)), np.zeros((4, count))
    # Innermost are sums over whole columns, which the processor works on at once.
    for k in range(begins.size):
        if begins[k] > 0.0:
            state[:] = 0.0
        else:
            screw = 5 if contact[k] > 0.0 else 4
            for i in range(4):
                for n in range(count):
                    follows[i, n] = (
                        step[i, 0] * state[0, n]
                        + step[i, 1] * state[1, n]
                        + step[i, 2] * state[2, n]
                        + step[i, 3] * state[3, n]
                        + step[i, 4] * state[4, n]
                        + step[i, 5] * state[screw, n]
                    )
            for i in range(4):
                for n in range(count):
                    state[i, n] = follows[i, n]
            for n in range(count):
                state[4, n] = state[screw, n]
        for n in range(count):
            found[k, n] = columns[k, n] - state[2, n]
        for i in range(6):
            for n in range(count):
                state[i, n] += gains[k, i] * found[k, n]
