"""The page of ``bdt reproduce``: claims first, then each figure with what was chosen for it."""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from bdt_analysis.pages.rendering import render_page
from bdt_study.limit_cycles.comparison import LimitCycleComparison, limit_cycle_rows
from bdt_study.reproduction.claim_robustness import ClaimRobustness
from bdt_study.reproduction.claims import Claim
from bdt_study.simulation.accuracy import Convergence

LOOP_CHOICES = (
    "Chosen, because the paper leaves it open: square reference 0 / 5 mm, 10 s a step, 120 s; "
    "gap 30° · (t / 120 s)², whose mean is the paper's 10°; gains of bdt design; control at "
    "500 Hz, voltage held between. How far the claims survive other choices: see the last sweep."
)


@dataclass(frozen=True)
class FigureText:
    """A figure of the page.

    Attributes
    ----------
    file : str
        File name.
    title, caption : str
        What it shows.
    choice : str
        What was chosen where the paper leaves it open; may be empty.
    claims : str
        Part of the claims beside it, see ``Claim.figure``; may be empty.
    """

    file: str
    title: str
    caption: str
    choice: str = ""
    claims: str = ""


STEPS_CAPTION = (
    "Residual q3 - r of each step, all panels with one scale. Orange: dead zone. Gray: the end on "
    "which a step is judged. A limit cycle oscillates there by more than 1 % of the amplitude "
    "without decay; its panel is shaded."
)

FIGURES = (
    FigureText(
        "figure_2.png",
        "Figure 2: the backlash model",
        "(a) Motor and lead screw over time, (b) one against the other.",
        "Shown time: 10 s. In place of an ODE with events eq. 6 is solved exactly over each "
        "sample of 0.2 ms: the play operator.",
        "fig2",
    ),
    FigureText(
        "figure_3.png",
        "Figure 3: linear controller, growing gap",
        "(a) Reference and position, steps with a limit cycle shaded; (b) motor voltage; (c) gap.",
        LOOP_CHOICES,
        "fig3",
    ),
    FigureText("figure_3_steps.png", "Figure 3, what is left of each step", STEPS_CAPTION),
    FigureText(
        "figure_4.png",
        "Figure 4: dead zone for a constant estimate",
        "As figure 3; (c) with the dead zone as the gap for which it is right.",
        LOOP_CHOICES + " Over-conservative means three times the mean gap.",
        "fig4",
    ),
    FigureText("figure_4_steps.png", "Figure 4, what is left of each step", STEPS_CAPTION),
    FigureText(
        "figure_6.png",
        "Figure 6: estimation after the fact",
        "(a) Command and output of the run of figure 4; (b) actual and estimated gap, each "
        "estimate in the middle of its window; (c) estimated minus true angle of the screw.",
        "5000 Hz, threshold 0.1 rad/s, N = 2 and l = 1/10 are the paper's. Chosen: eq. 13 over "
        "the newest 2 s, every 0.1 s; screw and motor must turn the same way.",
        "fig6",
    ),
    FigureText(
        "figure_7.png",
        "Figure 7: the reconfigurable controller",
        "As figure 4, with the estimate of the twin and the dead zone that it sets.",
        LOOP_CHOICES + " Telemetry in batches of 0.1 s, delay 1 s, first estimate zero.",
        "fig7",
    ),
    FigureText("figure_7_steps.png", "Figure 7, what is left of each step", STEPS_CAPTION),
    FigureText(
        "delays.png",
        "Sweep: communication delay",
        "Worst step of 12 for each delay; crosses mark runs with a limit cycle, dotted lines 1 % "
        "(the least size of a limit cycle) and 2 % of the amplitude. An older estimate that "
        "arrives late does not replace a newer one. Between steps there is nothing to estimate, "
        "so the gap of the last motion is used for up to 10 s anyway.",
    ),
    FigureText(
        "dead_zone_widths.png",
        "Sweep: dead-zone tolerance",
        "Constant gap of 20°, six steps a point. Too narrow: limit cycle. Too wide: bias, up to "
        "the dead-zone tolerance. The settling time depends on how q3 happens to enter the "
        "dead zone: it jumps, and grows with the tolerance only on average over many runs, if at "
        "all.",
    ),
    FigureText(
        "decisions.png",
        "Sweep: who decides on the dead zone",
        "Constant gaps, 18 steps a point, nominal mechanism. Eq. 9; the twin that simulates the "
        "next steps and commands the narrowest dead zone without a limit cycle; the same, which "
        "may set the gains that bdt tune recommends; and an oracle that knows the mechanism and "
        "what is to come, with the gains as they are. Dotted: half the width of the dead zone, the "
        "largest bias possible. Crosses: a limit cycle.",
        claims="decision",
    ),
    FigureText(
        "choices.png",
        "Sweep: everything that the paper leaves open",
        "Each claim again with one choice changed: a dot where it holds, a cross where not; "
        "the chosen value is shaded.",
    ),
    FigureText(
        "limit_cycles.png",
        "Limit cycles: theory beside simulation",
        "(a) The limit cycle is proportional to the gap, its frequency constant: loop and backlash "
        "are homogeneous. (b) The describing function takes theta_d for a sine. That holds for "
        "beams ten times as stiff; for table 1, whose first mode is three times the frequency of "
        "the limit cycle, the third harmonic is 0.45 of the fundamental and it does not. Harmonic "
        "balance up to the 15th harmonic holds for both.",
    ),
)


def reproduction_page(
    claims: Sequence[Claim],
    files: Collection[str],
    robustness_results: Sequence[ClaimRobustness],
    limit_cycles: Sequence[LimitCycleComparison],
    accuracy: Sequence[Convergence],
) -> str:
    """Return the text of ``index.html``.

    Parameters
    ----------
    claims : sequence of Claim
        All claims.
    files : collection of str
        Figures that lie beside the page.
    robustness_results : sequence of ClaimRobustness
        The claims for other choices.
    limit_cycles : sequence of LimitCycleComparison
        Predicted and simulated, over the gap.
    accuracy : sequence of Convergence
        Errors of the kernel over the step size.
    """
    failed = sum(not claim.holds for claim in claims)
    return render_page(
        "page.html",
        "bdt_study.reproduction",
        headline=f"{len(claims) - failed} of {len(claims)} claims hold",
        good=not failed,
        claims=[_claim_row(claim) for claim in claims],
        figures=[
            (figure, [_claim_row(claim) for claim in claims if claim.figure == figure.claims])
            for figure in FIGURES
            if figure.file in files
        ],
        failures=_failures(robustness_results),
        limit_cycles=limit_cycle_rows(limit_cycles),
        rates=[f"{rate:g}" for rate in accuracy[0].rates] if accuracy else [],
        accuracy=[
            (
                each.scenario,
                [f"{error:.1e}" for error in each.errors],
                "exact" if each.order is None else f"{each.order:.2f}",
            )
            for each in accuracy
        ],
    )


def _claim_row(claim: Claim) -> dict[str, str | bool]:
    return {
        "says": claim.paper_says,
        "measured": _number(claim.measured),
        "unit": claim.unit,
        "holds": claim.holds,
        "meaning": claim.meaning,
    }


def _failures(robustness_results: Sequence[ClaimRobustness]) -> list[tuple[str, str, str]]:
    """Return rows of (choice, claim, values for which it does not hold)."""
    rows = []
    for robustness in robustness_results:
        for number, claim in enumerate(robustness.claims[0]):
            holding = robustness.holding(number)
            failing = [f"{value:g}" for value in robustness.choice.values if value not in holding]
            if failing:
                rows.append((robustness.choice.name, claim.paper_says, ", ".join(failing)))
    return rows


def _number(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else "none"
