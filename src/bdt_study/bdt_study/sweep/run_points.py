"""The values of each run's parameters and its seed, functions of the study and its number alone."""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from bdt_study.sweep.run_batch import Points
from bdt_study.sweep.study import Study

FloatArray = NDArray[np.float64]

SEEDS = 2**31
"""Seeds that sensor and link know."""


class RunPoints:
    """The runs of a study in their order: grid, then samples, then repetitions.

    Parameters
    ----------
    study : Study
        The study.
    """

    def __init__(self, study: Study) -> None:
        self._study = study
        self._shape = tuple(len(axis.values) for axis in study.grid_axes)
        self._shared = _shared_fractions(study)

    def between(self, first: int, last: int) -> Points:
        """Return the runs from number `first` to before number `last`."""
        study = self._study
        numbers = np.arange(first, last)
        points, repetitions = np.divmod(numbers, study.repetitions)
        cells, samples = np.divmod(points, study.samples_at_each_point)
        places = np.unravel_index(cells, self._shape) if self._shape else ()
        grid = {
            axis.name: [axis.values[place] for place in column.tolist()]
            for axis, column in zip(study.grid_axes, places, strict=True)
        }
        drawn = self._drawn(points, samples)
        return Points(
            first,
            repetitions.tolist(),
            [_seed_of(study.seed, number) for number in numbers.tolist()],
            tuple((grid if axis.is_grid else drawn)[axis.name] for axis in study.axes),
        )

    def _drawn(
        self, points: NDArray[np.int64], samples: NDArray[np.int64]
    ) -> dict[str, list[float]]:
        axes = self._study.drawn_axes
        if not axes:
            return {}
        if self._shared is not None:
            fractions = self._shared[samples]
        else:
            # Drawn for each point by its number, so that nothing before it matters.
            fractions = np.array(
                [
                    np.random.default_rng(_sequence(self._study.seed, 1, point)).random(len(axes))
                    for point in points.tolist()
                ]
            )
        return {
            axis.name: [axis.value_at(fraction) for fraction in column]
            for axis, column in zip(axes, fractions.T.tolist(), strict=True)
        }


def _shared_fractions(study: Study) -> FloatArray | None:
    """Return the samples that all points of the grid have in common, shape (samples, axes)."""
    dimensions = len(study.drawn_axes)
    if not dimensions or study.method == "random":
        return None
    generator = np.random.default_rng(_sequence(study.seed, 2, 0))
    if study.method == "latin_hypercube":
        return np.asarray(qmc.LatinHypercube(dimensions, seed=generator).random(study.samples))
    if study.method == "sobol":
        return np.asarray(qmc.Sobol(dimensions, seed=generator).random(study.samples))
    base = np.asarray(qmc.Sobol(2 * dimensions, seed=generator).random(study.samples))
    return saltelli_design(base[:, :dimensions], base[:, dimensions:])


def saltelli_design(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the samples from which SALib computes first and total indices, in its order.

    Parameters
    ----------
    first, second : ndarray, shape (n, d)
        Two independent samples of the unit cube.

    Returns
    -------
    ndarray, shape (n (d + 2), d)
        For each of the n: the first sample, the first with one coordinate of the second for each
        coordinate in turn, the second sample.
    """
    count, dimensions = first.shape
    design = np.repeat(first[:, None, :], dimensions + 2, axis=1)
    for axis in range(dimensions):
        design[:, 1 + axis, axis] = second[:, axis]
    design[:, -1] = second
    return design.reshape(count * (dimensions + 2), dimensions)


def _seed_of(seed: int, run: int) -> int:
    return int(_sequence(seed, 0, run).generate_state(1)[0]) % SEEDS


def _sequence(seed: int, purpose: int, number: int) -> np.random.SeedSequence:
    return np.random.SeedSequence(seed, spawn_key=(purpose, number))
