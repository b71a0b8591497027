"""Residual of a fit as means over blocks of samples, without the samples that are outliers."""

from collections.abc import Sequence
from functools import reduce

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from bdt_twin.fixed_order import block_means, dot, mean, product
from bdt_twin.stretch import Stretch

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
    stretches : sequence of Stretch
        Measured positions.
    block : int
        Positions in a block; divides those of each stretch.
    """

    def __init__(self, stretches: Sequence[Stretch], block: int) -> None:
        self._stretches, self._block = stretches, block
        self._measured: FloatArray | None = None

    def means(self, simulated: Sequence[FloatArray]) -> FloatArray:
        """Return the means [m], shape (blocks,).

        Parameters
        ----------
        simulated : sequence of ndarray, each of shape (n,)
            Simulated position of each stretch [m].
        """
        means = np.concatenate([block_means(model, self._block) for model in simulated])
        if self._measured is None:
            pairs = zip(self._stretches, simulated, strict=True)
            self._measured = means + np.concatenate([self._off(*pair) for pair in pairs])
        residual: FloatArray = self._measured - means
        return residual

    def _off(self, stretch: Stretch, simulated: FloatArray) -> FloatArray:
        """Return the means of the readings that are no outliers, less the simulation."""
        readings = stretch.position if stretch.readings is None else stretch.readings
        every = readings.size // simulated.size
        if every > 1:
            instants = every * np.arange(simulated.size) + 0.5 * (every - 1)
            simulated = np.interp(np.arange(readings.size), instants, simulated)
        off = (readings - simulated).reshape(-1, every * self._block)
        good = inliers(off)
        means: FloatArray = reduce(np.add, (off * good).T) / reduce(np.add, good.T)
        return means


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
