"""The recorded telemetry given to an estimator again, and how well it did beside the live twin."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_analysis.metrics.gap_estimates import (
    GapEstimates,
    gap_estimates,
    live_gap_estimates,
    summarize_gap_estimates,
)
from bdt_analysis.metrics.re_estimation_summary import ReEstimationSummary
from bdt_analysis.re_estimation.estimator_setup import KIND, EstimatorSetup
from bdt_bags.reading.recording import Recording
from bdt_twin.estimator import Estimate, TelemetryRejectedError

FloatArray = NDArray[np.float64]

BATCH_TIME = 0.1
"""Telemetry given to the estimator at a time [s], where the bag has no batches."""


@dataclass(frozen=True, eq=False)
class ReEstimation:
    """A re-estimation.

    Attributes
    ----------
    estimates, live : GapEstimates
        What the estimator said, and what the twin said live.
    summary : ReEstimationSummary
        Both in numbers.
    """

    estimates: GapEstimates
    live: GapEstimates
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
    repeated = gap_estimates(np.array(rows, np.float64).reshape(-1, 3), recording.truth)
    live = live_gap_estimates(recording)
    summary = ReEstimationSummary(
        **vars(summarize_gap_estimates(repeated)),
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
        live=summarize_gap_estimates(live),
    )
    return ReEstimation(repeated, live, summary)


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
