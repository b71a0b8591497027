"""Which parameters a quantity depends on: Sobol's indices of a study sampled for them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from SALib.analyze import sobol

from bdt_study.sweep.sweep_table import SweepTable

FloatArray = NDArray[np.float64]

RESAMPLES = 200
"""Bootstrap samples behind an interval."""


@dataclass(frozen=True)
class SobolIndices:
    """Indices of one quantity.

    Attributes
    ----------
    quantity : str
        Its name.
    parameters : tuple of str
        The parameters.
    first, total : tuple of float
        First-order and total index of each.
    first_interval, total_interval : tuple of float
        Half of their 95 % intervals.
    samples : int
        Base samples in which the quantity is known of all runs.
    left_out : int
        Base samples in which it is not.
    """

    quantity: str
    parameters: tuple[str, ...]
    first: tuple[float, ...]
    total: tuple[float, ...]
    first_interval: tuple[float, ...]
    total_interval: tuple[float, ...]
    samples: int
    left_out: int


def has_indices(table: SweepTable) -> bool:
    """Tell whether a data set is a whole one whose samples tell indices, without a grid."""
    study = table.study
    is_whole = table.runs.size == study.runs
    return study.method == "saltelli" and is_whole and not study.grid_axes


def sobol_indices(table: SweepTable, quantities: Sequence[str]) -> list[SobolIndices]:
    """Return the indices of quantities that vary.

    Parameters
    ----------
    table : SweepTable
        Runs for which :func:`has_indices` holds.
    quantities : sequence of str
        Names of the quantities.

    Notes
    -----
    A. Saltelli et al., Variance based sensitivity analysis of model output. Design and estimator
    for the total sensitivity index, Computer Physics Communications 181 (2010).
    """
    study = table.study
    names = tuple(axis.name for axis in study.drawn_axes)
    found = []
    for quantity in quantities:
        by_point = table.columns[quantity].reshape(-1, study.repetitions).mean(axis=1)
        groups = by_point.reshape(study.samples, len(names) + 2)
        known = groups[~np.isnan(groups).any(axis=1)]
        if known.shape[0] < 2 or np.ptp(known) == 0.0:
            continue
        answer = sobol.analyze(
            {"num_vars": len(names), "names": list(names), "bounds": [[0.0, 1.0]] * len(names)},
            known.ravel(),
            calc_second_order=False,
            num_resamples=RESAMPLES,
            seed=study.seed,
        )
        found.append(
            SobolIndices(
                quantity,
                names,
                first=tuple(answer["S1"].tolist()),
                total=tuple(answer["ST"].tolist()),
                first_interval=tuple(answer["S1_conf"].tolist()),
                total_interval=tuple(answer["ST_conf"].tolist()),
                samples=len(known),
                left_out=len(groups) - len(known),
            )
        )
    return found
