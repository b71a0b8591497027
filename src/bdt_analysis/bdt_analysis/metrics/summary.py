"""The result of an analysis: what stands in ``summary.json``."""

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from bdt_analysis.metrics.decision_check import DecisionCheck, check_decisions
from bdt_analysis.metrics.estimate_analysis import EstimateSummary, summarize_estimate
from bdt_analysis.metrics.loop_timing import LoopTiming, summarize_timing
from bdt_analysis.metrics.missing_samples import interpolate_missing_samples
from bdt_analysis.metrics.performance_output import performance_output
from bdt_analysis.metrics.re_estimation_summary import ReEstimationSummary
from bdt_analysis.metrics.reconfigurations import (
    ReconfigurationSummary,
    summarize_reconfigurations,
)
from bdt_analysis.metrics.recording_holes import (
    RecordingHole,
    find_holes,
    hole_limits,
    hole_lines,
    unrecorded,
)
from bdt_analysis.metrics.reference_steps import ReferenceStep
from bdt_analysis.metrics.step_analysis import StepSummary, summarize_step
from bdt_bags.reading.completeness import late_beginnings, lost_messages
from bdt_bags.reading.recording import Recording


@dataclass(frozen=True)
class Summary:
    """A run in numbers; the fields are those of ``summary.json``, None is written as null.

    Attributes
    ----------
    duration_s : float
        Time covered by the telemetry [s].
    real_time_factor : float or None
        Simulated time per wall-clock time.
    steps : tuple of StepSummary
        The steps of the reference.
    estimate : EstimateSummary
        Estimate against truth, and its lag.
    reconfigurations : int or None
        Number of times that the controller's dead zone was set; None without parameter events.
    dead_zone_final_m : float or None
        Dead-zone tolerance at the end [m].
    messages : mapping of str to int
        Number of messages by topic.
    messages_left_out : mapping of str to int
        Number of messages that fit into no run, by topic; only topics that have any.
    lost_messages : int
        Number of missing measurements, commands and telemetry batches, from the first message
        of each topic on.
    lost_in_queue : int
        Number of those that a queue of the recorder has lost, which was late.
    missing_samples : int
        Number of samples of the telemetry whose position or voltage is not finite.
    missing : tuple of str
        What the bag lacks, each with what follows from it.
    holes : tuple of RecordingHole
        Stretches without samples or commands; a step with one is not judged.
    timing : LoopTiming
        Period, jitter, gaps and latency of the loop.
    reconfiguration_delay : ReconfigurationSummary
        How late the dead zones follow the estimates.
    re_estimation : ReEstimationSummary or None
        What an estimator made of the recorded telemetry; None when nobody asked.
    decisions : tuple of DecisionCheck
        What a twin that decides by simulation expected of each step, beside what happened.
    """

    duration_s: float
    real_time_factor: float | None
    steps: tuple[StepSummary, ...]
    estimate: EstimateSummary
    reconfigurations: int | None
    dead_zone_final_m: float | None
    messages: Mapping[str, int]
    messages_left_out: Mapping[str, int]
    lost_messages: int
    lost_in_queue: int
    missing_samples: int
    missing: tuple[str, ...]
    holes: tuple[RecordingHole, ...]
    timing: LoopTiming
    reconfiguration_delay: ReconfigurationSummary
    re_estimation: ReEstimationSummary | None
    decisions: tuple[DecisionCheck, ...] = ()

    def to_dictionary(self) -> dict[str, Any]:
        """Return what ``summary.json`` holds; a number that is not finite becomes None."""
        dictionary: dict[str, Any] = _finite(asdict(self))
        return dictionary

    def to_json(self) -> str:
        """Return the text of ``summary.json``."""
        return json.dumps(self.to_dictionary(), indent=2, allow_nan=False) + "\n"

    @property
    def limit_cycles(self) -> tuple[StepSummary, ...]:
        """Steps that end in a limit cycle."""
        return tuple(step for step in self.steps if step.limit_cycle)

    @property
    def worst_bias(self) -> StepSummary | None:
        """Step with the largest bias relative to its height, without its sign."""
        known = [step for step in self.steps if step.bias_percent_of_amplitude is not None]
        return max(known, key=lambda step: abs(step.bias_percent_of_amplitude or 0.0), default=None)

    @property
    def worst_residual(self) -> StepSummary | None:
        """Step with the largest peak to peak at its end."""
        known = [step for step in self.steps if step.residual_peak_to_peak_m is not None]
        return max(known, key=lambda step: step.residual_peak_to_peak_m or 0.0, default=None)


def summarize(
    recording: Recording,
    steps: list[ReferenceStep],
    re_estimation: ReEstimationSummary | None = None,
) -> Summary:
    """Return the summary of a run.

    Parameters
    ----------
    recording : Recording
        A loaded bag.
    steps : list of ReferenceStep
        Its steps.
    re_estimation : ReEstimationSummary, optional
        What an estimator made of its telemetry.
    """
    dead_zones = recording.dead_zones
    rows, sample_time = performance_output(recording)
    rows = interpolate_missing_samples(rows, sample_time)
    lost, holes = lost_messages(recording), find_holes(recording)
    judged = tuple(summarize_step(step, rows, sample_time) for step in steps)
    return Summary(
        duration_s=recording.duration,
        real_time_factor=recording.real_time_factor,
        steps=judged,
        estimate=summarize_estimate(recording, hole_limits(unrecorded(holes))),
        reconfigurations=recording.reconfigurations,
        dead_zone_final_m=float(dead_zones[-1, 1]) if len(dead_zones) else None,
        messages=recording.message_counts,
        messages_left_out=recording.left_out,
        lost_messages=lost.total,
        lost_in_queue=lost.in_queue,
        missing_samples=recording.missing_samples,
        missing=(*recording.missing, *late_beginnings(recording), *hole_lines(holes)),
        holes=holes,
        timing=summarize_timing(recording),
        reconfiguration_delay=summarize_reconfigurations(recording),
        re_estimation=re_estimation,
        decisions=check_decisions(recording.decisions, judged),
    )


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
