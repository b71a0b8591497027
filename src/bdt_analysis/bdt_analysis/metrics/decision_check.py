"""What a twin that decides by simulation expected of each step, beside what happened."""

from collections.abc import Sequence
from dataclasses import dataclass

from bdt_analysis.metrics.step_analysis import StepSummary
from bdt_bags.reading.twin_decisions import TwinDecision


@dataclass(frozen=True)
class DecisionCheck:
    """A step and the newest decision before it; an entry of ``decisions`` in ``summary.json``.

    Attributes
    ----------
    t_start_s : float
        Beginning of the step [s].
    reason : str
        Why the dead zone was decided on.
    ratio : float or None
        Dead zone over that of eq. 9; None for that of the rule.
    expected_bias_percent, bias_percent : float or None
        Largest bias that was expected, and size of the bias that came [% of the height].
    expected_settling_s, settling_s : float or None
        Median settling time that was expected, and the time that it took [s].
    limit_cycle : bool or None
        Whether the step ended in a limit cycle, which no decision expects.
    taken_back : int
        Decisions that were taken back until then.
    """

    t_start_s: float
    reason: str
    ratio: float | None
    expected_bias_percent: float | None
    bias_percent: float | None
    expected_settling_s: float | None
    settling_s: float | None
    limit_cycle: bool | None
    taken_back: int


def check_decisions(
    decisions: Sequence[TwinDecision], steps: Sequence[StepSummary]
) -> tuple[DecisionCheck, ...]:
    """Return expectation and outcome of each step that has a decision before it.

    Parameters
    ----------
    decisions : sequence of TwinDecision
        Decisions in the order of time.
    steps : sequence of StepSummary
        The steps.
    """
    checks = []
    for step in steps:
        before = [each for each in decisions if each.time <= step.t_start_s]
        if not before:
            continue
        decision, bias = before[-1], step.bias_percent_of_amplitude
        checks.append(
            DecisionCheck(
                step.t_start_s,
                decision.reason,
                decision.ratio,
                decision.expected_bias_percent,
                None if bias is None else abs(bias),
                decision.expected_settling,
                step.settling_time_s,
                step.limit_cycle,
                decision.taken_back,
            )
        )
    return tuple(checks)
