"""The outcomes of an evaluation as a table for the terminal."""

from collections.abc import Sequence

from rich.table import Table

from bdt_study.evaluation.outcome import CaseOutcome


def outcome_table(outcomes: Sequence[CaseOutcome]) -> Table:
    """Return the outcomes as a table for the terminal."""
    table = Table(title=f"gap estimates in closed loop, {outcomes[0].runs} random runs each")
    table.add_column("case", no_wrap=True)
    table.add_column("estimator", no_wrap=True)
    table.add_column("decision", no_wrap=True)
    for name in (
        "rms error [deg]",
        "worst [deg]",
        "95 % covers [%]",
        "x CRB",
        "no limit cycle [%]",
        "avoidable [%]",
        "spared [%]",
        "bias < 2 % [%]",
        "bias [%]",
        "settling [s]",
        "window [ms]",
    ):
        table.add_column(name, justify="right")
    for row in outcomes:
        table.add_row(
            row.case,
            row.estimator,
            row.decision,
            _text(row.rms_error_deg, ".2g"),
            _text(row.worst_error_deg, ".2g"),
            _text(row.coverage_95, ".0f"),
            _text(row.crb_ratio, ".1f"),
            _text(row.limit_cycle_free_percent, ".0f"),
            _text(row.avoidable_steps_percent, ".1f"),
            _text(row.spared_steps_percent, ".0f"),
            _text(row.bias_under_2_percent, ".0f"),
            _text(row.worst_bias_percent, ".2f"),
            _text(row.settling_s, ".1f"),
            _text(row.window_ms, ".0f"),
        )
    return table


def _text(value: float | None, form: str) -> str:
    return "-" if value is None else f"{value:{form}}"
