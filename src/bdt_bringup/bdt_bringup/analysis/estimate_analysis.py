"""The estimate of the gap against the true gap, and how late the dead zone follows it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SAME_VALUE = 1e-9
"""Relative difference below which a dead zone is the one of an estimate."""

COVERAGE_FACTOR = 1.96
"""Standard uncertainties on either side of an interval that covers 95 %."""


@dataclass(frozen=True)
class EstimateSummary:
    """The estimate in numbers; the fields of ``estimate`` in ``summary.json``.

    Attributes
    ----------
    rms_error_rad, max_error_rad : float or None
        Root mean square and largest absolute difference between the estimate in force and the
        true gap [rad], from the first estimate to the end; None without truth or estimates.
    worst_lag_s : float or None
        Longest time from the newest sample behind an estimate until the dead zone took its value
        [s]; None when no dead zone came from an estimate.
    """

    rms_error_rad: float | None
    max_error_rad: float | None
    worst_lag_s: float | None


def estimate_errors(truth: FloatArray, estimates: FloatArray) -> FloatArray:
    """Return rows of (time [s], error of the estimate in force [rad]) at the times of the truth.

    An estimate is in force from the newest sample that it used until the next one: that is what
    an estimator without communication delay would have known. Before the first there is no error.

    Parameters
    ----------
    truth : ndarray, shape (m, 7)
        Rows of (t, theta_m, theta_d, gap, q1, q2, q3) [s, rad, m].
    estimates : ndarray, shape (k, 2)
        Rows of (time [s], gap [rad]) in the order of time.

    Returns
    -------
    ndarray, shape (j, 2)
        Errors, positive where the estimate is too large.
    """
    in_force = np.searchsorted(estimates[:, 0], truth[:, 0], side="right") - 1
    known = in_force >= 0
    error = estimates[in_force[known], 1] - truth[known, 3]
    return np.stack([truth[known, 0], error], axis=1)


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


def reconfiguration_lags(estimates: FloatArray, dead_zones: FloatArray, pitch: float) -> FloatArray:
    """Return how long after its data each estimate reached the controller.

    The lag of a reconfiguration runs from the stamp of the estimate (its newest sample) to the
    time at which the dead zone took the value p times that estimate (eq. 9). It holds the batch,
    the communication delay and the service call, but not the window over which the estimator
    averages.

    Parameters
    ----------
    estimates : ndarray, shape (k, 2)
        Rows of (time of the newest sample [s], gap [rad]) in the order of time.
    dead_zones : ndarray, shape (j, 2)
        Rows of (time [s], dead-zone tolerance [m]) in the order of time.
    pitch : float
        Pitch p of the lead screw [m/rad].

    Returns
    -------
    ndarray, shape (i, 2)
        Rows of (time of the reconfiguration [s], lag [s]).
    """
    matches = matching_estimates(estimates, dead_zones, pitch)
    known = matches >= 0
    times = dead_zones[known, 0]
    return np.stack([times, times - estimates[matches[known], 0]], axis=1)


def matching_estimates(
    estimates: FloatArray, dead_zones: FloatArray, pitch: float
) -> NDArray[np.intp]:
    """Return which estimate is behind each dead zone.

    The values themselves tell which estimate it was; a dead zone that somebody else set belongs
    to none.

    Parameters
    ----------
    estimates, dead_zones, pitch
        See :func:`reconfiguration_lags`.

    Returns
    -------
    ndarray of int, shape (j,)
        Rows of `estimates`, increasing; -1 for none.
    """
    stamps, tolerances = estimates[:, 0], pitch * np.maximum(estimates[:, 1], 0.0)
    following = 0
    matches = np.full(len(dead_zones), -1, np.intp)
    for number, (time, value) in enumerate(dead_zones.tolist()):
        newest = int(np.searchsorted(stamps, time, side="right"))
        same = np.isclose(tolerances[following:newest], value, rtol=SAME_VALUE, atol=0.0)
        if same.any():
            # Estimates are delivered in order: the first one not yet delivered is meant.
            matches[number] = following + int(np.argmax(same))
            following = int(matches[number]) + 1
    return matches


def summarize_estimate(
    truth: FloatArray | None, estimates: FloatArray, dead_zones: FloatArray, pitch: float
) -> EstimateSummary:
    """Return the numbers of the estimate; see the functions above for the definitions.

    Parameters
    ----------
    truth : ndarray, shape (m, 7), or None
        Truth, if the bag has it.
    estimates, dead_zones : ndarray, shape (k, 2)
        See :func:`reconfiguration_lags`.
    pitch : float
        Pitch p of the lead screw [m/rad].
    """
    errors = np.empty((0, 2)) if truth is None else estimate_errors(truth, estimates)
    lags = reconfiguration_lags(estimates, dead_zones, pitch)
    return EstimateSummary(
        rms_error_rad=float(np.sqrt(np.mean(errors[:, 1] ** 2))) if len(errors) else None,
        max_error_rad=float(np.max(np.abs(errors[:, 1]))) if len(errors) else None,
        worst_lag_s=float(np.max(lags[:, 1])) if len(lags) else None,
    )
