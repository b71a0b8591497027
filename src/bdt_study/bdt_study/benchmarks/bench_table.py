"""Results of the benchmarks as a table for the terminal."""

from collections.abc import Iterable, Mapping
from typing import Any

from rich.table import Table


def bench_table(results: Iterable[Mapping[str, Any]]) -> Table:
    """Return a table with one row a result: value, reference and ratio.

    Parameters
    ----------
    results : iterable of mapping
        Entries of ``results`` from :func:`bdt_study.benchmarks.bench.run_benchmarks`.
    """
    table = Table("benchmark", "value", "unit", "reference", "its value", "ratio")
    for result in results:
        table.add_row(
            result["name"],
            _number(result["value"]),
            result["unit"],
            result["reference"],
            f"{result['target']} {_number(result['reference_value'])}".strip(),
            _number(result["ratio"]),
        )
    return table


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"
