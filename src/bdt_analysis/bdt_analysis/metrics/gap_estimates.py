"""What was stated about the gap, each of it once, and its errors at the times it speaks of."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_bags.run_signals import RunSignals

FloatArray = NDArray[np.float64]

TRUE_GAP = 3
"""Column of the truth."""

COVERAGE_FACTOR = 1.96
"""Standard uncertainties on either side of an interval that covers 95 %."""


@dataclass(frozen=True, eq=False)
class GapEstimates:
    """What somebody said about the gap.

    Attributes
    ----------
    time, gap, uncertainty : ndarray, shape (n,)
        Time for which the gap is stated [s], increasing; gap and its standard uncertainty [rad],
        NaN where none was stated.
    error : ndarray, shape (n,)
        Gap less true gap at that time [rad]; NaN where the bag has no truth.
    """

    time: FloatArray
    gap: FloatArray
    uncertainty: FloatArray
    error: FloatArray


@dataclass(frozen=True)
class GapEstimatesSummary:
    """Gap estimates in numbers.

    Attributes
    ----------
    estimates : int
        Number of estimates; one that only repeats the last does not count.
    rms_error_deg, worst_error_deg : float or None
        Errors at the times for which the gap is stated [deg]; None without truth or estimates.
    coverage_95_percent : float or None
        Share of the estimates whose stated 95 % interval holds the true gap [%]; None where no
        uncertainty is stated.
    """

    estimates: int
    rms_error_deg: float | None
    worst_error_deg: float | None
    coverage_95_percent: float | None


def gap_estimates(rows: FloatArray, truth: FloatArray | None) -> GapEstimates:
    """Return what was stated, each of it once, with the errors.

    Parameters
    ----------
    rows : ndarray, shape (n, 3)
        Rows of (time [s], gap, standard uncertainty [rad]) in the order in which they were stated.
    truth : ndarray, shape (m, 7), or None
        Truth, if the bag has it; the true gap is interpolated between its rows.
    """
    # A twin that learns nothing repeats its last estimate, of the same time.
    news = np.ones(len(rows), np.bool_)
    news[1:] = (np.diff(rows[:, :2], axis=0) != 0.0).any(axis=1)
    rows = rows[news]
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    when, gap, uncertainty = rows.T
    if truth is None:
        return GapEstimates(when, gap, uncertainty, np.full(when.shape, np.nan))
    true_gap = np.interp(when, truth[:, 0], truth[:, TRUE_GAP], left=np.nan, right=np.nan)
    return GapEstimates(when, gap, uncertainty, gap - true_gap)


def live_gap_estimates(run: RunSignals) -> GapEstimates:
    """Return what the twin said while the loop ran.

    Parameters
    ----------
    run : RunSignals
        A run, with or without truth.
    """
    rows = np.column_stack([run.estimates[:, :2], np.full(len(run.estimates), np.nan)])
    following = 0
    for stamp, uncertainty in run.uncertainties:
        # Estimates of the same time are told apart by their order.
        following = max(following, int(np.searchsorted(rows[:, 0], stamp)))
        if following < len(rows) and rows[following, 0] == stamp:
            rows[following, 2] = uncertainty
            following += 1
    return gap_estimates(rows, run.truth)


def summarize_gap_estimates(stated: GapEstimates) -> GapEstimatesSummary:
    """Return gap estimates in numbers."""
    errors = np.rad2deg(stated.error[np.isfinite(stated.error)])
    return GapEstimatesSummary(
        estimates=len(stated.gap),
        rms_error_deg=math.sqrt(float(np.mean(errors**2))) if errors.size else None,
        worst_error_deg=float(np.abs(errors).max()) if errors.size else None,
        coverage_95_percent=interval_coverage(stated.error, stated.uncertainty),
    )


def interval_coverage(errors: FloatArray, uncertainties: FloatArray) -> float | None:
    """Return the share of the stated 95 % intervals that hold the truth [%].

    Parameters
    ----------
    errors, uncertainties : ndarray, shape (n,)
        Errors and their stated standard uncertainties, in the same unit; NaN where unknown.

    Returns
    -------
    float or None
        None where nothing is stated.
    """
    stated = np.isfinite(errors) & np.isfinite(uncertainties)
    covered = np.abs(errors[stated]) <= COVERAGE_FACTOR * uncertainties[stated]
    return 100.0 * float(covered.mean()) if covered.size else None
