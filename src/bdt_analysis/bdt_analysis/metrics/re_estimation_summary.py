"""A re-estimation of the gap in numbers."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bdt_analysis.metrics.gap_estimates import GapEstimatesSummary


@dataclass(frozen=True)
class ReEstimationSummary(GapEstimatesSummary):
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
    live : GapEstimatesSummary
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
    live: GapEstimatesSummary
