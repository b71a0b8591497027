"""The trials of one case and one estimator as one row of the table."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bdt_analysis.metrics.gap_estimates import interval_coverage
from bdt_study.evaluation.trial import Trial
from bdt_study.reproduction.claims import LARGEST_BIAS


@dataclass(frozen=True)
class CaseOutcome:
    """One row; the fields of an entry of ``cases`` in the JSON output.

    What it tells of loops is of the steps that nothing pushes while they are judged.

    Attributes
    ----------
    case, estimator, decision : str
        What was evaluated.
    rms_error_deg, worst_error_deg : float or None
        Error of the estimates over all runs [deg]; None when there were none.
    coverage_95 : float or None
        Share of the estimates [%] whose stated 95 % interval holds the true gap; None for an
        estimator that states none.
    crb_ratio : float or None
        Rms error over the rms Cramér-Rao bound, at the ends of the steps; None where the model is
        not exact or there is no noise.
    limit_cycle_free_percent : float
        Share of the runs without a limit cycle [%].
    avoidable_limit_cycle_percent : float
        Share of the runs with a limit cycle in a step that has none with the true gap as dead zone
        [%].
    avoidable_steps_percent : float or None
        Share of the steps with a limit cycle among those that have none with the true gap [%];
        None when there are no such steps.
    spared_steps_percent : float or None
        Share of the steps without a limit cycle among those that have one with the true gap [%];
        None when there are no such steps.
    bias_under_2_percent : float
        Share of the runs whose worst bias is below 2 % of the amplitude [%].
    worst_bias_percent : float
        Median over the runs of the worst bias [% of the amplitude].
    settling_s : float or None
        Median settling time of all steps [s]; None if the median step does not settle.
    taken_back : int
        Number of simulated decisions that were taken back.
    window_ms : float or None
        Median of the processor time of an estimate [ms].
    runs : int
        Number of runs.
    pushed_steps : int
        Number of steps that something pushes while they are judged.
    pushed_limit_cycles, pushed_limit_cycles_with_true_gap : int
        How many of them are taken for a limit cycle, and how many with the true gap.
    """

    case: str
    estimator: str
    decision: str
    rms_error_deg: float | None
    worst_error_deg: float | None
    coverage_95: float | None
    crb_ratio: float | None
    limit_cycle_free_percent: float
    avoidable_limit_cycle_percent: float
    avoidable_steps_percent: float | None
    spared_steps_percent: float | None
    bias_under_2_percent: float
    worst_bias_percent: float
    settling_s: float | None
    taken_back: int
    window_ms: float | None
    runs: int
    pushed_steps: int = 0
    pushed_limit_cycles: int = 0
    pushed_limit_cycles_with_true_gap: int = 0


def summarize_trials(
    case: str, estimator: str, trials: Sequence[Trial], decision: str = "equation_9"
) -> CaseOutcome:
    """Return the row of a case and an estimator.

    Parameters
    ----------
    case, estimator : str
        What was evaluated.
    trials : sequence of Trial
        Its runs, at least one.
    decision : str
        How the twin decided.
    """
    settling = np.concatenate([trial.settling_times for trial in trials])
    middle = float(np.median(settling)) if settling.size else math.inf
    errors = np.concatenate([trial.errors for trial in trials])
    sigmas = np.concatenate([trial.uncertainties for trial in trials])
    bounds = np.concatenate([trial.bounds for trial in trials])
    at_bounds = np.concatenate([trial.bound_errors for trial in trials])
    times = np.concatenate([trial.window_times for trial in trials])
    avoidable = sum(trial.avoidable_limit_cycles for trial in trials)
    steps = sum(trial.avoidable_steps for trial in trials)
    # Each step has a settling time. Some have a limit cycle with the true gap, and of these some
    # have one here, too.
    unavoidable = settling.size - steps
    shared = sum(trial.limit_cycles for trial in trials) - avoidable
    return CaseOutcome(
        case,
        estimator,
        decision,
        math.degrees(_rms(errors)) if errors.size else None,
        math.degrees(float(np.abs(errors).max())) if errors.size else None,
        interval_coverage(errors, sigmas),
        _rms(at_bounds) / _rms(bounds) if bounds.size else None,
        100.0 * float(np.mean([trial.limit_cycles == 0 for trial in trials])),
        100.0 * float(np.mean([trial.avoidable_limit_cycles > 0 for trial in trials])),
        100.0 * avoidable / steps if steps else None,
        100.0 * (unavoidable - shared) / unavoidable if unavoidable > 0 else None,
        100.0 * float(np.mean([trial.worst_bias < LARGEST_BIAS for trial in trials])),
        float(np.median([trial.worst_bias for trial in trials])),
        middle if math.isfinite(middle) else None,
        sum(trial.taken_back for trial in trials),
        1e3 * float(np.median(times)) if times.size else None,
        len(trials),
        sum(trial.pushed_steps for trial in trials),
        sum(trial.pushed_limit_cycles for trial in trials),
        sum(trial.pushed_with_true_gap for trial in trials),
    )


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
