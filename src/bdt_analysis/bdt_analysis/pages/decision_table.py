"""Decisions of the twin as a table: expected beside what happened."""

from collections.abc import Sequence

from bdt_analysis.metrics.decision_check import DecisionCheck
from bdt_analysis.pages.table import Column, Row, Table, number

COLUMNS = (
    Column("step begins at", "s"),
    Column("dead zone", "of eq. 9"),
    Column("bias expected, at most", "%"),
    Column("bias", "%"),
    Column("settling expected, median", "s"),
    Column("settling", "s"),
    Column("limit cycle", text=True),
    Column("taken back"),
    Column("reason", text=True),
)


def decision_table(checks: Sequence[DecisionCheck]) -> Table | None:
    """Return what was expected of each step beside what happened; None without decisions.

    Parameters
    ----------
    checks : sequence of DecisionCheck
        Steps with a decision by simulation before them.
    """
    if not checks:
        return None
    rows = [
        Row(
            (
                number(each.t_start_s, ".6g"),
                number(each.ratio, ".3g"),
                number(each.expected_bias_percent, ".2f"),
                number(each.bias_percent, ".2f"),
                number(each.expected_settling_s, ".2f"),
                number(each.settling_s, ".2f"),
                "" if each.limit_cycle is None else ("yes" if each.limit_cycle else "no"),
                str(each.taken_back),
                each.reason,
            ),
            alarm=bool(each.limit_cycle),
        )
        for each in checks
    ]
    note = (
        "The newest decision before each step. What is expected is of simulated steps with "
        "mechanisms that the twin thinks possible; a decision may arrive after the step has begun."
    )
    return Table("decisions", "What the twin expected, and what happened", COLUMNS, rows, note)
