"""How often something happens, over one parameter or two, and how sure that is."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta

FloatArray = NDArray[np.float64]

CONFIDENCE = 0.95
MOST_EDGES = 60
"""Most values of a parameter that are shown one by one; more are put into bins."""
BINS = 20


@dataclass(frozen=True, eq=False)
class Shares:
    """How often something happened in each cell.

    Attributes
    ----------
    counts, hits : ndarray of int
        Runs of each cell, and those in which it happened.
    shares : ndarray
        Their ratio; NaN in a cell without runs.
    low, high : ndarray
        Clopper-Pearson interval of the probability, 0 to 1 in a cell without runs.
    """

    counts: NDArray[np.int64]
    hits: NDArray[np.int64]
    shares: FloatArray
    low: FloatArray
    high: FloatArray


def clopper_pearson(
    hits: NDArray[np.int64], counts: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """Return the exact 95 % interval of a probability, which covers it at least so often.

    Parameters
    ----------
    hits, counts : ndarray of the same shape
        Successes and trials.

    Notes
    -----
    C. J. Clopper, E. S. Pearson, The use of confidence or fiducial limits illustrated in the case
    of the binomial, Biometrika 26 (1934).
    """
    tail = 0.5 * (1.0 - CONFIDENCE)
    misses = counts - hits
    low = np.where(hits > 0, beta.ppf(tail, np.maximum(hits, 1), misses + 1), 0.0)
    high = np.where(misses > 0, beta.ppf(1.0 - tail, hits + 1, np.maximum(misses, 1)), 1.0)
    return low, high


def shares_of(happened: FloatArray, *places: NDArray[np.int64], shape: tuple[int, ...]) -> Shares:
    """Return how often something happened in each cell.

    Parameters
    ----------
    happened : ndarray, shape (n,)
        1 where it happened, 0 where not, NaN where that is unknown: such a run does not count.
    *places : ndarray, shape (n,)
        Number of the cell along each axis.
    shape : tuple of int
        Cells along each axis.
    """
    known = ~np.isnan(happened)
    cells = np.ravel_multi_index(tuple(place[known] for place in places), shape)
    size = int(np.prod(shape))
    counts = np.bincount(cells, minlength=size).reshape(shape)
    hits = np.bincount(cells[happened[known] > 0.5], minlength=size).reshape(shape)
    low, high = clopper_pearson(hits, counts)
    with np.errstate(invalid="ignore"):
        return Shares(counts, hits, hits / counts, low, high)


def means_of(values: FloatArray, *places: NDArray[np.int64], shape: tuple[int, ...]) -> FloatArray:
    """Return the mean of a quantity in each cell, NaN in one where it is unknown everywhere."""
    known = ~np.isnan(values)
    cells = np.ravel_multi_index(tuple(place[known] for place in places), shape)
    size = int(np.prod(shape))
    counts = np.bincount(cells, minlength=size)
    with np.errstate(invalid="ignore"):
        sums = np.bincount(cells, weights=values[known], minlength=size)
        means: FloatArray = (sums / counts).reshape(shape)
    return means


def binned(values: FloatArray) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return the middles of cells along a parameter, and the cell of each run.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Value of the parameter in each run: few different ones are cells of their own, many are put
        into equal bins.
    """
    different = np.unique(values)
    if different.size <= MOST_EDGES:
        return different, np.searchsorted(different, values)
    edges = np.linspace(different[0], different[-1], BINS + 1)
    places = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, BINS - 1)
    return 0.5 * (edges[1:] + edges[:-1]), places
