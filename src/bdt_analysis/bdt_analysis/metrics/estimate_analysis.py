"""The estimate in numbers: its error, and how late the dead zone follows it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_analysis.metrics.dead_zone_requests import reconfiguration_lags
from bdt_analysis.metrics.gap_estimates import live_gap_estimates
from bdt_analysis.metrics.reference_steps import NO_HOLES
from bdt_bags.run_signals import RunSignals

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class EstimateSummary:
    """The estimate in numbers; the fields of ``estimate`` in ``summary.json``.

    Attributes
    ----------
    rms_error_rad, max_error_rad : float or None
        Root mean square and largest absolute difference between the estimate in force and the
        true gap [rad], from the first estimate to the end, an estimate in force from the time for
        which it is stated; None without truth or estimates.
    worst_lag_s : float or None
        Longest time from the newest sample behind an estimate until the dead zone took its value
        [s]; None when no dead zone came from an estimate.
    stated_rms_error_rad, stated_max_error_rad : float or None
        Root mean square and largest absolute error of the estimates, each at the time for which it
        is stated [rad]; None without truth or estimates.
    max_shortfall_rad : float or None
        Largest amount by which the true gap exceeds the estimate that the twin holds, from the
        newest sample behind an estimate until that of the next one [rad]; 0 when it never does,
        None without truth or estimates. A bound of the gap has to make up for it, and for what
        the gap grows during the communication delay.
    voltage_offset_v : float or None
        Voltage that the twin asked the controller to add to its commands last, against an offset
        of the amplifier [V]; None when it asked for none.
    """

    rms_error_rad: float | None
    max_error_rad: float | None
    worst_lag_s: float | None
    stated_rms_error_rad: float | None
    stated_max_error_rad: float | None
    max_shortfall_rad: float | None
    voltage_offset_v: float | None


def estimate_errors(
    truth: FloatArray, estimates: FloatArray, holes: FloatArray = NO_HOLES
) -> FloatArray:
    """Return rows of (time [s], error of the estimate in force [rad]) at the times of the truth.

    An estimate is in force from its time until that of the next one. Before the first there is no
    error, and none from a hole on until the first estimate behind it.

    Parameters
    ----------
    truth : ndarray, shape (m, 7)
        Rows of (t, theta_m, theta_d, gap, q1, q2, q3) [s, rad, m].
    estimates : ndarray, shape (k, 2)
        Rows of (time from which an estimate is in force [s], gap [rad]) in the order of time.
    holes : ndarray, shape (h, 2)
        Begin and end of stretches that were not recorded [s].

    Returns
    -------
    ndarray, shape (j, 2)
        Errors, positive where the estimate is too large.
    """
    in_force = np.searchsorted(estimates[:, 0], truth[:, 0], side="right") - 1
    known = in_force >= 0
    since = estimates[np.maximum(in_force, 0), 0] if len(estimates) else truth[:, 0]
    for begin, end in holes:
        known &= (truth[:, 0] < begin) | (since > end)
    error = estimates[in_force[known], 1] - truth[known, 3]
    return np.stack([truth[known, 0], error], axis=1)


def summarize_estimate(run: RunSignals, holes: FloatArray = NO_HOLES) -> EstimateSummary:
    """Return the numbers of the estimate, as :class:`EstimateSummary` defines them.

    Parameters
    ----------
    run : RunSignals
        A run, with or without truth.
    holes : ndarray, shape (h, 2)
        Begin and end of stretches that were not recorded [s].
    """
    truth = np.empty((0, 7)) if run.truth is None else run.truth
    in_force = estimate_errors(truth, run.estimates, holes)[:, 1]
    # Windows that end with the same reversal state the gap for times that differ by a sample or
    # two, in any order. What the twin holds is in the order of the newest samples.
    said = run.held_gaps if len(run.held_gaps) else run.estimates
    held = estimate_errors(truth, said, holes)[:, 1]
    stated = live_gap_estimates(run).error
    stated = stated[np.isfinite(stated)]
    lags = reconfiguration_lags(run)
    offsets = run.voltage_offset_requests
    return EstimateSummary(
        rms_error_rad=_rms(in_force),
        max_error_rad=_largest(np.abs(in_force)),
        worst_lag_s=_largest(lags[:, 1]),
        stated_rms_error_rad=_rms(stated),
        stated_max_error_rad=_largest(np.abs(stated)),
        max_shortfall_rad=_largest(np.maximum(-held, 0.0)),
        voltage_offset_v=float(offsets[-1, 1]) if len(offsets) else None,
    )


def _rms(values: FloatArray) -> float | None:
    return float(np.sqrt(np.mean(values**2))) if values.size else None


def _largest(values: FloatArray) -> float | None:
    return float(values.max()) if values.size else None
