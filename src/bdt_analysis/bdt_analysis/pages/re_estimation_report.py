"""A re-estimation beside the live twin, in words for the terminal and as a table for the report."""

from bdt_analysis.metrics.gap_estimates import GapEstimatesSummary
from bdt_analysis.metrics.re_estimation_summary import ReEstimationSummary
from bdt_analysis.pages.table import Column, Row, Table, number


def re_estimation_lines(summary: ReEstimationSummary) -> list[str]:
    """Return a re-estimation beside the live estimates in one line, then what else to know."""
    each = "" if summary.window_ms is None else f", {summary.window_ms:.3g} ms each"
    beside = (
        f"re-estimated ({summary.estimator}): {_numbers(summary)}{each}; "
        f"live: {_numbers(summary.live)}"
    )
    return [beside, *(f"  {remark}" for remark in remarks(summary))]


def remarks(summary: ReEstimationSummary) -> list[str]:
    """Return what else is to be known about a re-estimation: settings, and what was of no use."""
    lines = [
        f"{origin} {', '.join(f'{name} = {value}' for name, value in values.items())}"
        for origin, values in (
            ("set", summary.settings),
            ("from the bag", summary.recorded_settings),
        )
        if values
    ]
    if summary.without_effect:
        names = ", ".join(summary.without_effect)
        lines.append(f"no effect on {summary.estimator}: {names}")
    if summary.kept_reason is not None:
        lines.append(
            f"windows that taught nothing: {summary.kept}, the first: {summary.kept_reason}"
        )
    if summary.rejected_reason is not None:
        lines.append(f"batches rejected: {summary.rejected}, the first: {summary.rejected_reason}")
    return lines


def re_estimation_table(re_estimation: ReEstimationSummary) -> Table:
    """Return what an estimator made of the telemetry beside what the twin said live.

    Parameters
    ----------
    re_estimation : ReEstimationSummary
        Both in numbers.
    """

    def row(quantity: str, unit: str, name: str, form: str) -> Row:
        both = (
            number(getattr(summary, name, None), form)
            for summary in (re_estimation.live, re_estimation)
        )
        return Row((quantity, *both, unit))

    return Table(
        key="re-estimation",
        title=f"Re-estimated with {re_estimation.estimator}",
        columns=(
            Column("quantity", text=True),
            Column("live"),
            Column("re-estimated"),
            Column("unit", text=True),
        ),
        rows=[
            row("estimates", "", "estimates", ".0f"),
            row("gap error where stated, root mean square", "deg", "rms_error_deg", ".3g"),
            row("gap error where stated, largest", "deg", "worst_error_deg", ".3g"),
            row("95 % intervals that hold the true gap", "%", "coverage_95_percent", ".1f"),
            row("windows that taught nothing", "", "kept", ".0f"),
            row("telemetry batches rejected", "", "rejected", ".0f"),
            row("processor time of an estimate, median", "ms", "window_ms", ".3g"),
        ],
        note=" ".join(f"{line[0].upper()}{line[1:]}." for line in remarks(re_estimation)),
    )


def _numbers(summary: GapEstimatesSummary) -> str:
    parts = [f"{summary.estimates} estimates"]
    if summary.rms_error_deg is not None and summary.worst_error_deg is not None:
        parts += [
            f"error {summary.rms_error_deg:.3g} deg rms",
            f"{summary.worst_error_deg:.3g} deg at worst",
        ]
    if summary.coverage_95_percent is not None:
        parts.append(f"95 % intervals hold {summary.coverage_95_percent:.0f} %")
    return ", ".join(parts)
