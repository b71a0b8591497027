"""What was tried as a table for the terminal, and the reason of the recommendation."""

import math

from rich.box import SIMPLE
from rich.markup import escape
from rich.table import Table

from bdt_study.tuning.candidate_outcome import Candidate
from bdt_study.tuning.tune import Tuning

COLUMNS = (
    "width",
    "M_s",
    "PM\n[deg]",
    "failed",
    "95 %\n[%]",
    "t_s\n[s]",
    "M_p\n[%]",
    "bias\n[%]",
    "worst\n[%]",
    "peak\n[V]",
)
LEGEND = (
    "width: dead zone over eq. 9; M_s, PM: largest sensitivity and smallest phase margin; failed: "
    "loops with a limit cycle, 95 %: interval of their share; t_s settling, M_p overshoot and bias "
    "in the median, worst bias and peak voltage of all. Last part: the loops that confirm."
)


def candidates_table(result: Tuning) -> Table:
    """Return all candidates with what they cost, and below what the confirmation gave."""
    table = Table(
        title="controllers on a mechanism within ranges",
        caption=LEGEND,
        caption_justify="left",
        box=SIMPLE,
        padding=0,
    )
    table.add_column("candidate", no_wrap=True)
    for name in COLUMNS:
        table.add_column(escape(name), justify="right", no_wrap=True)
    for candidate in result.screened:
        _add_row(table, candidate, candidate.tried.design.name)
    table.add_section()
    _add_row(table, result.baseline, "as it is, nominal")
    _add_row(table, result.before, "as it is")
    _add_row(table, result.recommended, result.recommended.tried.design.name)
    return table


def verdict(result: Tuning) -> str:
    """Return what is recommended and why, in one line."""
    chosen, lacks = result.recommended, result.lacks(result.recommended)
    filtered = chosen.tried.design.notch.frequency > 0.0
    reason = (
        f"{chosen.loops - chosen.failures} of {chosen.loops} random loops without a limit cycle "
        f"(before: {result.before.loops - result.before.failures}), largest sensitivity "
        f"{chosen.linear.largest_sensitivity:.2f} (before: "
        f"{result.before.linear.largest_sensitivity:.2f}), settling "
        f"{chosen.settling / result.baseline.settling:.2f} times that of the nominal mechanism "
        "with the gains so far"
    )
    pids = [one for one in result.screened if not one.tried.design.notch.frequency]
    if filtered:
        best = min(pids, key=lambda one: len(result.lacks(one)))
        reason += (
            f"; no PID reaches the targets, the nearest lacks: {'; '.join(result.lacks(best))}"
        )
    name = f"{chosen.tried.design.name}, dead zone {chosen.tried.dead_zone.ratio:g} times eq. 9"
    if lacks:
        return f"nothing reaches the targets; {name} comes nearest but lacks {'; '.join(lacks)}"
    return f"recommended: {name}, with the smallest bias of what reaches the targets: {reason}"


def _add_row(table: Table, candidate: Candidate, name: str) -> None:
    low, high = (100.0 * share for share in candidate.failure_interval)
    table.add_row(
        name,
        f"{candidate.tried.dead_zone.ratio:g}",
        f"{candidate.linear.largest_sensitivity:.2f}",
        f"{math.degrees(candidate.linear.smallest_phase_margin):.1f}",
        f"{candidate.failures}/{candidate.loops}",
        f"{low:.2g}-{high:.2g}",
        f"{candidate.settling:.2f}",
        f"{candidate.overshoot:.0f}",
        f"{candidate.bias:.2f}",
        f"{candidate.worst_bias:.2f}",
        f"{candidate.voltage_peak:.0f}",
    )
