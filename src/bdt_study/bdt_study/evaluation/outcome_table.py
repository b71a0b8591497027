"""The outcomes of an evaluation as tables that a terminal of 80 columns holds."""

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

from bdt_study.evaluation.outcome import CaseOutcome


class _Column(NamedTuple):
    """A number of the outcome: what stands above it, its field, and its format."""

    header: str
    field: str
    form: str


ESTIMATES = (
    _Column("rms error\n[deg]", "rms_error_deg", ".2g"),
    _Column("worst\n[deg]", "worst_error_deg", ".2g"),
    _Column("95 %\ncovers [%]", "coverage_95", ".0f"),
    _Column("x CRB", "crb_ratio", ".1f"),
    _Column("window\n[ms]", "window_ms", ".0f"),
)
"""How good the estimates are."""
LOOPS = (
    _Column("no limit\ncycle [%]", "limit_cycle_free_percent", ".0f"),
    _Column("avoidable\n[%]", "avoidable_steps_percent", ".1f"),
    _Column("spared\n[%]", "spared_steps_percent", ".0f"),
    _Column("bias <\n2 % [%]", "bias_under_2_percent", ".0f"),
    _Column("bias\n[%]", "worst_bias_percent", ".2f"),
    _Column("settling\n[s]", "settling_s", ".1f"),
)
"""What became of the loops."""


def outcome_tables(outcomes: Sequence[CaseOutcome]) -> list[Table]:
    """Return a table of the estimates and one of the loops, each by estimator and decision.

    Parameters
    ----------
    outcomes : sequence of CaseOutcome
        At least one.
    """
    runs = f"{outcomes[0].runs} random runs each"
    loops = _table(f"their loops, {runs}", LOOPS, outcomes)
    loops.caption, loops.caption_justify = _pushed(outcomes), "left"
    return [_table(f"gap estimates in closed loop, {runs}", ESTIMATES, outcomes), loops]


def _pushed(outcomes: Sequence[CaseOutcome]) -> str | None:
    """Return what the loops' table does not tell of, if there is something."""
    steps, cycles, with_true_gap = (
        sum(getattr(each, name) for each in outcomes)
        for name in ("pushed_steps", "pushed_limit_cycles", "pushed_limit_cycles_with_true_gap")
    )
    if not steps:
        return None
    return (
        f"without {steps} steps that something pushed while they were judged; {cycles} of them "
        f"look like a limit cycle, with the true gap {with_true_gap}"
    )


def _table(title: str, columns: Sequence[_Column], outcomes: Sequence[CaseOutcome]) -> Table:
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("case", no_wrap=True)
    for column in columns:
        table.add_column(escape(column.header), justify="right", no_wrap=True)
    # Stable, so the cases of an estimator stay in their order.
    ordered = sorted(outcomes, key=_twin)
    for (estimator, decision), rows in groupby(ordered, key=_twin):
        table.add_row(f"[bold]{escape(estimator)}[/bold]\n{escape(decision)}")
        for row in rows:
            numbers = (_text(getattr(row, each.field), each.form) for each in columns)
            table.add_row(row.case, *numbers)
        table.add_section()
    return table


def _twin(outcome: CaseOutcome) -> tuple[str, str]:
    return outcome.estimator, outcome.decision


def _text(value: float | None, form: str) -> str:
    return "-" if value is None else f"{value:{form}}"
