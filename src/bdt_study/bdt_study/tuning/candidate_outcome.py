"""A candidate in numbers: what python-control and the random loops say of it."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.stats import binomtest

from bdt_study.tuning.linear_judgment import LinearJudgment
from bdt_study.tuning.loop_trial import LoopOutcome, Tried

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Candidate:
    """A candidate and what it costs.

    Attributes
    ----------
    tried : Tried
        Controller and rule of the dead zone.
    linear : LinearJudgment
        Margins without backlash.
    loops, failures : int
        Number of random loops, and of those with a limit cycle.
    failure_interval : tuple of float
        Clopper-Pearson interval of the share of failures at 95 % confidence.
    settling : float
        Median settling time over all steps [s].
    overshoot : float
        Median overshoot over all steps [% of the height].
    bias, worst_bias : float
        Median over the loops of the worst bias, and the worst of all [% of the height].
    voltage_peak : float
        Largest voltage [V].
    """

    tried: Tried
    linear: LinearJudgment
    loops: int
    failures: int
    failure_interval: tuple[float, float]
    settling: float
    overshoot: float
    bias: float
    worst_bias: float
    voltage_peak: float

    @property
    def success(self) -> float:
        """Share of the loops without a limit cycle."""
        return 1.0 - self.failures / self.loops

    def to_dictionary(self) -> dict[str, Any]:
        """Return the candidate for JSON; what is not finite becomes None."""
        design, rule = self.tried.design, self.tried.dead_zone
        linear = asdict(self.linear)
        phase_margin = math.degrees(linear.pop("smallest_phase_margin"))
        return {
            "name": design.name,
            "pid": asdict(design.gains),
            "notch": asdict(design.notch),
            "dead_zone": {"ratio": rule.ratio, "margin": rule.margin},
            "linear": {
                **{name: _finite(value) for name, value in linear.items()},
                "smallest_phase_margin_deg": phase_margin,
            },
            "loops": self.loops,
            "failures": self.failures,
            "failure_interval_95": list(self.failure_interval),
            "settling_median_s": _finite(self.settling),
            "overshoot_median_percent": self.overshoot,
            "bias_median_percent": self.bias,
            "bias_worst_percent": self.worst_bias,
            "voltage_peak_v": self.voltage_peak,
        }


def summarize(tried: Tried, linear: LinearJudgment, outcomes: Sequence[LoopOutcome]) -> Candidate:
    """Return a candidate with what its loops gave.

    Parameters
    ----------
    tried : Tried
        Controller and rule.
    linear : LinearJudgment
        Its margins.
    outcomes : sequence of LoopOutcome
        Its loops, at least one.
    """
    failures = sum(one.limit_cycles > 0 for one in outcomes)
    interval = binomtest(failures, len(outcomes)).proportion_ci(CONFIDENCE, method="exact")
    biases = [one.worst_bias for one in outcomes]
    return Candidate(
        tried,
        linear,
        len(outcomes),
        failures,
        (float(interval.low), float(interval.high)),
        float(np.median([time for one in outcomes for time in one.settling_times])),
        float(np.median([share for one in outcomes for share in one.overshoots])),
        float(np.median(biases)),
        max(biases),
        max(one.voltage_peak for one in outcomes),
    )


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
