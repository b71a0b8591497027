"""The recorded telemetry given to an estimator again, and how well it did beside the live twin."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_bringup.analysis.estimate_analysis import interval_coverage
from bdt_bringup.analysis.estimator_setup import KIND, EstimatorSetup
from bdt_bringup.bags.recording import Recording
from bdt_twin.estimator import Estimate, TelemetryRejectedError

FloatArray = NDArray[np.float64]

BATCH_TIME = 0.1
"""Telemetry given to the estimator at a time [s], where the bag has no batches."""

TRUE_GAP = 3
"""Column of the truth."""


@dataclass(frozen=True, eq=False)
class StatedGaps:
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
class StatedGapsSummary:
    """Stated gaps in numbers.

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


@dataclass(frozen=True)
class ReEstimationSummary(StatedGapsSummary):
    """A re-estimation in numbers; the fields of ``re_estimation`` in ``summary.json``.

    Attributes
    ----------
    estimator : str
        Kind of the estimator.
    settings : mapping of str
        What the command line set beside the kind.
    recorded_settings : mapping of str
        What the twin's parameters in the bag set other than by default.
    without_effect : tuple of str
        Settings of the command line that the estimator does not look at.
    sampling_rate_hz : float
        Sampling rate of the telemetry [Hz].
    kept : int
        Number of windows that taught nothing.
    kept_reason : str or None
        Why the first of them did not.
    rejected : int
        Number of batches of no use to the estimator.
    rejected_reason : str or None
        Why the first of them was not.
    window_ms : float or None
        Median of the processor time of an estimate [ms].
    live : StatedGapsSummary
        The same numbers of what the twin said live.
    """

    estimator: str
    settings: Mapping[str, Any]
    recorded_settings: Mapping[str, Any]
    without_effect: tuple[str, ...]
    sampling_rate_hz: float
    kept: int
    kept_reason: str | None
    rejected: int
    rejected_reason: str | None
    window_ms: float | None
    live: StatedGapsSummary


@dataclass(frozen=True, eq=False)
class ReEstimation:
    """A re-estimation.

    Attributes
    ----------
    again, live : StatedGaps
        What the estimator said, and what the twin said live.
    summary : ReEstimationSummary
        Both in numbers.
    """

    again: StatedGaps
    live: StatedGaps
    summary: ReEstimationSummary


def re_estimate(recording: Recording, setup: EstimatorSetup) -> ReEstimation:
    """Give the telemetry of a recording to an estimator, in batches as the twin got them.

    Parameters
    ----------
    recording : Recording
        The run.
    setup : EstimatorSetup
        The estimator.

    Raises
    ------
    BadInputError
        If there is no such estimator.
    """
    estimator = setup.create()
    estimates: list[Estimate] = []
    faults: list[str] = []
    seconds: list[float] = []
    for batch in telemetry_batches(recording, setup.sampling_rate):
        began = time.thread_time()
        try:
            estimate = estimator.update(batch)
        except TelemetryRejectedError as error:
            faults.append(str(error))
            continue
        if estimate is not None:
            estimates.append(estimate)
            seconds.append(time.thread_time() - began)
    reasons = [estimate.reason for estimate in estimates if estimate.reason]
    rows = [(x.time, x.gap, x.uncertainty) for x in estimates if x.is_known]
    again = stated_gaps(np.array(rows, np.float64).reshape(-1, 3), recording.truth)
    live = stated_gaps(_live_rows(recording), recording.truth)
    summary = ReEstimationSummary(
        **vars(summarize_stated_gaps(again)),
        estimator=setup.kind,
        settings={name: value for name, value in setup.given.items() if name != KIND},
        recorded_settings=setup.recorded,
        without_effect=setup.without_effect,
        sampling_rate_hz=setup.sampling_rate,
        kept=len(reasons),
        kept_reason=reasons[0] if reasons else None,
        rejected=len(faults),
        rejected_reason=faults[0] if faults else None,
        window_ms=1e3 * float(np.median(seconds)) if seconds else None,
        live=summarize_stated_gaps(live),
    )
    return ReEstimation(again, live, summary)


def telemetry_batches(recording: Recording, sampling_rate: float) -> Sequence[FloatArray]:
    """Return the telemetry rows (t [s], u [V], q3 [m]) in batches as long as the recorded ones.

    Batches begin at multiples of their length after the first sample, whatever is missing: a
    hole stays within its batch.

    Parameters
    ----------
    recording : Recording
        The run.
    sampling_rate : float
        Sampling rate of the telemetry [Hz].
    """
    rows = recording.telemetry
    length = recording.batch_rows or max(round(BATCH_TIME * sampling_rate), 1)
    numbers = np.rint((rows[:, 0] - recording.sample_times[0]) * sampling_rate) // length
    return np.split(rows, np.flatnonzero(np.diff(numbers)) + 1)


def stated_gaps(rows: FloatArray, truth: FloatArray | None) -> StatedGaps:
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
        return StatedGaps(when, gap, uncertainty, np.full(when.shape, np.nan))
    true_gap = np.interp(when, truth[:, 0], truth[:, TRUE_GAP], left=np.nan, right=np.nan)
    return StatedGaps(when, gap, uncertainty, gap - true_gap)


def summarize_stated_gaps(stated: StatedGaps) -> StatedGapsSummary:
    """Return stated gaps in numbers."""
    errors = np.rad2deg(stated.error[np.isfinite(stated.error)])
    return StatedGapsSummary(
        estimates=len(stated.gap),
        rms_error_deg=math.sqrt(float(np.mean(errors**2))) if errors.size else None,
        worst_error_deg=float(np.abs(errors).max()) if errors.size else None,
        coverage_95_percent=interval_coverage(stated.error, stated.uncertainty),
    )


def _live_rows(recording: Recording) -> FloatArray:
    """Return rows of (time, gap, uncertainty) of the twin; NaN for an uncertainty not stated."""
    rows = np.column_stack([recording.estimates[:, :2], np.full(len(recording.estimates), np.nan)])
    following = 0
    for stamp, uncertainty in recording.uncertainties:
        # Estimates of the same time are told apart by their order.
        following = max(following, int(np.searchsorted(rows[:, 0], stamp)))
        rows[following, 2] = uncertainty
        following += 1
    return rows
