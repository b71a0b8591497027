"""What the paper claims about figures 3, 4, 6 and 7, each beside what was measured.

A claim is a function of the simulations, so that the same claims can be asked again of other
choices (:mod:`bdt_study.reproduction.claim_robustness`).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_plant.gap_profile import gaps_at
from bdt_study.reproduction.experiments import Experiment, PaperRuns

FloatArray = NDArray[np.float64]

CONVERGED = 0.01
"""Peak to peak at the end of a step, as a part of the amplitude, below which q3 has converged."""

LARGEST_BIAS = 2.0
"""Largest bias that the paper reports for figure 7 [% of the amplitude]."""

GOOD_ESTIMATE = 0.1
"""Error of an estimate, as a part of the largest gap, up to which it follows the gap."""


@dataclass(frozen=True)
class Claim:
    """A claim of the paper and what was measured.

    Attributes
    ----------
    id : str
        Name, which begins with the figure.
    paper_says : str
        The claim.
    measured : float
        What stands for it.
    unit : str
        Unit of `measured`.
    holds : bool
        Whether the claim holds.
    meaning : str
        What was measured, and from which value on the claim holds.
    """

    id: str
    paper_says: str
    measured: float
    unit: str
    holds: bool
    meaning: str

    @property
    def figure(self) -> str:
        """What the claim is about: ``design``, ``fig2``, ``fig3``, ..."""
        return self.id.split("_", maxsplit=1)[0]

    def to_dictionary(self) -> dict[str, str | float | bool | None]:
        """Return the entry of ``claims.json``; a number that is not finite becomes None."""
        return {
            "id": self.id,
            "paper_says": self.paper_says,
            "measured": self.measured if math.isfinite(self.measured) else None,
            "unit": self.unit,
            "holds": self.holds,
        }


def small_gap_converges(runs: PaperRuns) -> Claim:
    """Figure 3: the first step, in which the gap is smallest."""
    residual = 100 * float(runs.linear.residuals[0]) / runs.choices.amplitude
    return Claim(
        "fig3_small_gap_converges",
        "When the width is small, q3 converges to the reference.",
        residual,
        "% of the amplitude",
        bool(residual < 100 * CONVERGED and not runs.linear.limit_cycles[0]),
        "linear controller: peak to peak of q3 at the end of the first step; below 1 %",
    )


def large_gap_limit_cycle(runs: PaperRuns) -> Claim:
    """Figure 3: from some gap on every step ends in a limit cycle."""
    cycles = runs.linear.limit_cycles
    first = int(np.argmax(cycles)) if cycles.any() else cycles.size
    gap = math.degrees(runs.linear.gaps[first]) if cycles.any() else math.nan
    return Claim(
        "fig3_large_gap_limit_cycle",
        "A limit cycle is observed when the width becomes more significant.",
        gap,
        "deg",
        bool(cycles[first:].all() and cycles.any()),
        "linear controller: gap at the end of the first step with a limit cycle; "
        "every step after it has one, too",
    )


def fixed_dead_zone_fails(runs: PaperRuns) -> Claim:
    """Figure 4: stable up to the modeled gap, not far beyond it."""
    cycles, ratio = runs.fixed.limit_cycles, runs.fixed.gaps / runs.choices.mean_gap
    first = float(ratio[np.argmax(cycles)]) if cycles.any() else math.nan
    return Claim(
        "fig4_fixed_dead_zone_fails",
        "The system again loses stability when the real gap is significantly larger than the "
        "modeled one.",
        first,
        "times the modeled gap",
        bool(cycles.any() and not cycles[ratio <= 1.0].any()),
        "dead zone for the mean gap: true gap at the end of the first step with a limit cycle; "
        "none while the gap is smaller than modeled",
    )


def dead_zone_prolongs_settling(runs: PaperRuns) -> Claim:
    """Figure 4: slower than without a dead zone while the gap is smaller than modeled."""
    ratio = _mean_settling(runs.fixed, runs) / _mean_settling(runs.linear, runs)
    return Claim(
        "fig4_settling_gets_longer",
        "When the actual gap is smaller than the modeled one, the settling time gets longer.",
        ratio,
        "times that of the linear controller",
        ratio > 1.0,
        "mean settling time to 2 % over the steps that end with a gap smaller than modeled",
    )


def too_wide_costs_bias(runs: PaperRuns) -> Claim:
    """Text: a dead zone of three times the mean gap, while the gap is below its mean."""
    below = _below_mean(runs)
    wide, right = (float(each.biases[below].max()) for each in (runs.wide, runs.reconfigured))
    return Claim(
        "fig4_over_conservative_bias",
        "If the dead zone is tuned too conservatively, a significant bias is introduced.",
        wide,
        "% of the amplitude",
        wide > right,
        "dead zone for three times the mean gap, steps with a gap below the mean: worst bias; "
        f"larger than with the dead zone that follows the gap ({right:.2g} %)",
    )


def too_wide_prolongs_settling(runs: PaperRuns) -> Claim:
    """Text: such a dead zone settles later than the one that follows the gap."""
    ratio = _mean_settling(runs.wide, runs) / _mean_settling(runs.reconfigured, runs)
    return Claim(
        "fig4_over_conservative_settling",
        "If the dead zone is tuned too conservatively, the settling time can become "
        "significantly longer.",
        ratio,
        "times that of the reconfigured one",
        ratio > 1.0,
        "mean settling time to 2 % over the steps with a gap below the mean, dead zone for three "
        "times the mean gap",
    )


def estimate_follows_gap(runs: PaperRuns) -> Claim:
    """Figure 6: estimates from the finished run of figure 4."""
    errors, largest = post_processing_errors(runs), float(runs.fixed.gaps.max())
    error = math.degrees(np.abs(errors[:, 1]).max()) if len(errors) else math.nan
    return Claim(
        "fig6_estimate_follows_gap",
        "Post-processed, the estimation algorithm successfully identifies the gap.",
        error,
        "deg",
        bool(error <= math.degrees(GOOD_ESTIMATE * largest)),
        "largest error against the true gap in the middle of the window; "
        "at most a tenth of the largest gap",
    )


def reconfigured_is_stable(runs: PaperRuns) -> Claim:
    """Figure 7: no limit cycle in any step."""
    cycles = int(runs.reconfigured.limit_cycles.sum())
    return Claim(
        "fig7_stable_at_all_times",
        "The reconfigurable controller restabilizes the system at all times.",
        float(cycles),
        "steps with a limit cycle",
        cycles == 0 and bool((runs.reconfigured.biases < 100.0).all()),
        f"dead zone set by the twin, delay 1 s, {runs.reconfigured.gaps.size} steps; none",
    )


def bias_is_small(runs: PaperRuns) -> Claim:
    """Figure 7: the worst bias of all steps."""
    worst = float(runs.reconfigured.biases.max())
    return Claim(
        "fig7_worst_bias",
        "The worst bias is under 2 % of the required reference amplitude.",
        worst,
        "% of the amplitude",
        worst < LARGEST_BIAS,
        "dead zone set by the twin, delay 1 s: worst bias of all steps; below 2 %",
    )


CLAIMS: tuple[Callable[[PaperRuns], Claim], ...] = (
    small_gap_converges,
    large_gap_limit_cycle,
    fixed_dead_zone_fails,
    dead_zone_prolongs_settling,
    too_wide_costs_bias,
    too_wide_prolongs_settling,
    estimate_follows_gap,
    reconfigured_is_stable,
    bias_is_small,
)
"""Claims that depend on what the paper leaves open."""


def post_processing_errors(runs: PaperRuns) -> FloatArray:
    """Return rows of (middle of the window [s], estimate minus true gap [rad]) for figure 6."""
    times, estimates = runs.post_processed.T
    return np.stack([times, estimates - gaps_at(runs.choices.gap, times)], axis=1)


def _below_mean(runs: PaperRuns) -> NDArray[np.bool_]:
    return np.asarray(runs.fixed.gaps <= runs.choices.mean_gap)


def _mean_settling(experiment: Experiment, runs: PaperRuns) -> float:
    """Return the mean settling time [s] over the steps with a gap below the mean."""
    times = experiment.settling_times[_below_mean(runs)]
    known = times[np.isfinite(times)]
    return float(known.mean()) if known.size else math.nan
