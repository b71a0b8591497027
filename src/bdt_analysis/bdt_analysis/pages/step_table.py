"""The steps of a run as a short table for the terminal."""

from rich.table import Table

from bdt_analysis.metrics.step_analysis import StepSummary
from bdt_analysis.metrics.summary import Summary


def step_table(summary: Summary) -> Table:
    """Return a table with one row a step: reference, residual, bias, settling, limit cycle.

    Parameters
    ----------
    summary : Summary
        From :func:`bdt_analysis.analyze.analyze`.
    """
    table = Table()
    for column in ("begin, s", "r, mm", "residual p-p, um", "bias, %", "settling, s"):
        table.add_column(column, justify="right")
    table.add_column("limit cycle")
    for step in summary.steps:
        table.add_row(
            f"{step.t_start_s:g}",
            f"{step.reference_m * 1e3:g}",
            _number(step.residual_peak_to_peak_m, 1e6, ".1f"),
            _number(step.bias_percent_of_amplitude, 1.0, "+.2f"),
            _number(step.settling_time_s, 1.0, ".2f"),
            _limit_cycle(step),
        )
    return table


def _limit_cycle(step: StepSummary) -> str:
    """Return whether there is a limit cycle and, if so, its amplitude and frequency."""
    if not step.limit_cycle:
        return "-" if step.limit_cycle is None else "no"
    amplitude = _number(step.limit_cycle_amplitude_m, 1e6, ".3g")
    return f"{amplitude} um, {_number(step.limit_cycle_frequency_hz, 1.0, '.2f')} Hz"


def _number(value: float | None, scale: float, form: str) -> str:
    return "-" if value is None else format(value * scale, form)
