"""Inverses of information matrices, whose unknowns differ by many orders of magnitude."""

import numpy as np
from numpy.typing import NDArray

from bdt_twin.fixed_order import solution

FloatArray = NDArray[np.float64]


def inverse(information: FloatArray, right: FloatArray | None = None) -> FloatArray:
    """Return the inverse of an information matrix, or its product with a matrix."""
    scale = 1.0 / np.sqrt(np.diag(information))
    scaled = information * np.outer(scale, scale) + 1e-12 * np.eye(scale.size)
    if right is None:
        return solution(scaled, np.eye(scale.size)) * np.outer(scale, scale)
    return scale[:, None] * solution(scaled, scale[:, None] * right)


def solved(information: FloatArray, gradient: FloatArray) -> FloatArray:
    """Return the step to where the gradient vanishes."""
    step: FloatArray = inverse(information, gradient[:, None])[:, 0]
    return step
