"""The estimate in numbers: its error, and how late the dead zone follows it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_bringup.analysis.dead_zone_requests import reconfiguration_lags
from bdt_bringup.run_signals import RunSignals

FloatArray = NDArray[np.float64]


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

    An estimate is in force from the time for which it is stated until that of the next one: that
    is what an estimator without communication delay would have known. Before the first there is
    no error.

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


def summarize_estimate(run: RunSignals) -> EstimateSummary:
    """Return the numbers of the estimate, as :class:`EstimateSummary` defines them.

    Parameters
    ----------
    run : RunSignals
        A run, with or without truth.
    """
    errors = np.empty((0, 2)) if run.truth is None else estimate_errors(run.truth, run.estimates)
    lags = reconfiguration_lags(run)
    return EstimateSummary(
        rms_error_rad=float(np.sqrt(np.mean(errors[:, 1] ** 2))) if len(errors) else None,
        max_error_rad=float(np.max(np.abs(errors[:, 1]))) if len(errors) else None,
        worst_lag_s=float(np.max(lags[:, 1])) if len(lags) else None,
    )
