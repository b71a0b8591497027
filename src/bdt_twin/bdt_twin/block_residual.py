"""Residual of a fit as means over blocks of samples, without the samples that are outliers."""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from bdt_plant.compilation import GIVEN, WRITTEN, compile_loop
from bdt_twin.fixed_order import dot, mean, product

FloatArray = NDArray[np.float64]

OUTLIER = 12.0
"""Median deviations from its block's median beyond which a sample is an outlier."""
SMALLEST_SCREENED = 5
"""Samples that a block must have for its median to tell outliers."""
LONGEST_CORRELATION = 1.0
"""Time over which the residual's correlation is summed [s]."""


class BlockResidual:
    """Means of measured less simulated positions.

    Outliers are told from the rest of their block once, at the first simulation: within
    milliseconds even a wrong model is off by nearly the same everywhere.

    Parameters
    ----------
    positions : sequence of ndarray, each of shape (n,)
        Measured position q3 of each stretch [m].
    block : int
        Samples in a block; divides each n.
    """

    def __init__(self, positions: Sequence[FloatArray], block: int) -> None:
        self._positions = [np.ascontiguousarray(position) for position in positions]
        self._block = block
        self._good: list[FloatArray] | None = None

    def means(self, simulated: Sequence[FloatArray]) -> FloatArray:
        """Return the means [m], shape (blocks,).

        Parameters
        ----------
        simulated : sequence of ndarray, each of shape (n,)
            Simulated position of each stretch [m].
        """
        pairs = list(zip(self._positions, simulated, strict=True))
        if self._good is None:
            self._good = [
                inliers((measured - model).reshape(-1, self._block)) for measured, model in pairs
            ]
        means = [np.empty(len(good)) for good in self._good]
        for (measured, model), good, found in zip(pairs, self._good, means, strict=True):
            compiled_means()(measured, model, good, found)
        return np.concatenate(means)


def inliers(residual: FloatArray) -> FloatArray:
    """Return one for each sample to use and zero for each outlier; half a block is good at least.

    Parameters
    ----------
    residual : ndarray, shape (blocks, samples)
        Measured less simulated position [m].
    """
    if residual.shape[1] < SMALLEST_SCREENED:
        return np.ones(residual.shape)
    distance = np.abs(residual - _medians(residual))
    spread = _medians(distance)
    # Where the platform rests, a coarse sensor shows no spread at all.
    allowed = OUTLIER * np.maximum(spread, mean(spread[:, 0]))
    good: FloatArray = (distance <= allowed + np.finfo(np.float64).eps).astype(np.float64)
    return good


def _medians(values: FloatArray) -> FloatArray:
    """Return the median of each row, shape (rows, 1)."""
    # Sorted by vector instructions; numpy.median takes seven times as long.
    ordered, half = np.sort(values, axis=1), values.shape[1] // 2
    low = ordered[:, half - 1 + values.shape[1] % 2, None]
    medians: FloatArray = 0.5 * (low + ordered[:, half, None])
    return medians


def variance_inflation(residual: FloatArray, rate: float) -> float:
    """Return by how many times the variance of a mean exceeds that of white noise, at least one.

    The sum of the autocorrelation with Bartlett's weights (Newey and West, 1987): what is slow in
    the residual is what the gap is confused with.

    Parameters
    ----------
    residual : ndarray, shape (blocks,)
        Residual of each block.
    rate : float
        Blocks in a second [Hz].
    """
    longest = min(round(LONGEST_CORRELATION * rate), residual.size // 4)
    delayed = sliding_window_view(np.concatenate([residual, np.zeros(longest)]), residual.size)
    covariance = product(delayed, residual)
    if covariance[0] <= 0:
        return 1.0
    weights = 1.0 - np.arange(1, longest + 1) / (longest + 1)
    return max(1.0, 1.0 + 2.0 * dot(weights, covariance[1:]) / float(covariance[0]))


@cache
def compiled_means() -> Any:
    """Return the loop over the samples of :meth:`BlockResidual.means`, compiled."""
    matrix = "Array(float64, 2, 'C', readonly=True)"
    return compile_loop(_mean_residuals, f"void({GIVEN}, {GIVEN}, {matrix}, {WRITTEN})")


def _mean_residuals(
    measured: FloatArray, simulated: FloatArray, good: FloatArray, means: FloatArray
) -> None:
    samples = good.shape[1]
    for block in range(means.size):
        total, count = 0.0, 0.0
        for sample in range(samples):
            k = block * samples + sample
            total += (measured[k] - simulated[k]) * good[block, sample]
            count += good[block, sample]
        means[block] = total / count
