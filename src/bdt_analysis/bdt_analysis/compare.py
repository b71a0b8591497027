"""The command ``bdt compare``: one page that overlays the runs of several bags."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table as TerminalTable

from bdt_analysis.figures.comparison_figure import comparison_figure
from bdt_analysis.figures.figure_style import svg_text
from bdt_analysis.figures.interactive import interactive_part
from bdt_analysis.figures.run_figures import time_label
from bdt_analysis.metrics.compared_runs import ComparedRun, load_runs
from bdt_analysis.pages.comparison import (
    all_steps_table,
    compared_panels,
    compared_series,
    plotted_runs,
    runs_table,
)
from bdt_analysis.pages.rendering import render_page
from bdt_analysis.pages.table import Table
from bdt_analysis.pages.timing_tables import timing_tables
from bdt_bags.bag_error import BagError
from bdt_bags.reading.topic_selection import TopicSelection
from bdt_msgs_py.output_files import prepare_output, real_path

TERMINAL_COLUMNS = (
    "run",
    "limit cycles",
    "worst bias",
    "worst residual, peak to peak",
    "gap error, rms",
)
"""Columns of the table of runs that the terminal shows."""


def run_comparison(
    bags: Sequence[Path],
    output: Path,
    selection: TopicSelection | None = None,
    *,
    as_json: bool,
) -> None:
    """Compare bags, write the page and print the table or the numbers.

    Parameters
    ----------
    bags : sequence of Path
        Two bags or more.
    output : Path
        The page; one that exists is replaced.
    selection : TopicSelection, optional
        Which loop and which topics are meant, in every bag.
    as_json : bool
        True to print :func:`comparison_dictionary` instead of a table.

    Raises
    ------
    BagError
        If a bag cannot be analyzed or the page cannot be written.
    """
    if len(bags) < 2:
        raise BagError(f"compare: has {len(bags)} bag: must have two or more")
    _check_output(output)
    prepare_output("--output", output)
    runs = load_runs(bags, selection)
    page = comparison_page(runs)
    try:
        output.write_text(page, encoding="utf-8")
    except OSError as error:
        raise BagError(f"--output {output}: cannot be written: {error.strerror or error}") from None
    if as_json:
        print(json.dumps(comparison_dictionary(runs), indent=2, allow_nan=False))
        return
    console = Console()
    console.print(_terminal_table(runs_table(runs)))
    console.print(f"page: {output}", soft_wrap=True, highlight=False)


def comparison_page(runs: Sequence[ComparedRun]) -> str:
    """Return the text of the page.

    Parameters
    ----------
    runs : sequence of ComparedRun
        From :func:`bdt_analysis.metrics.compared_runs.load_runs`.
    """
    stable = sum(not run.summary.limit_cycles for run in runs)
    holed = sum(bool(run.summary.holes) for run in runs)
    holes = f", {holed} with holes: a step with one is not judged" if holed else ""
    return render_page(
        "comparison.html",
        headline=f"{len(runs)} runs, {stable} of them without a limit cycle" + holes,
        runs=[(run.name, str(run.recording.path)) for run in runs],
        picture=svg_text(comparison_figure(runs), "comparison"),
        plots=interactive_part(
            compared_panels(runs),
            compared_series(runs),
            plotted_runs(runs),
            time_label(runs[0].recording),
        ),
        runs_table=runs_table(runs),
        steps=all_steps_table(runs),
        timing=timing_tables([(run.name, run.summary) for run in runs]),
    )


def comparison_dictionary(runs: Sequence[ComparedRun]) -> dict[str, Any]:
    """Return what ``--json`` prints: for each run its name, bag and ``summary.json``."""
    return {
        "runs": [
            {"name": run.name, "bag": str(run.recording.path), **run.summary.to_dictionary()}
            for run in runs
        ]
    }


def _check_output(output: Path) -> None:
    """Refuse a place in a bag, which is left as it is, and a folder."""
    if output.is_dir():
        raise BagError(f"--output {output}: is a folder: must be a file")
    if any((folder / "metadata.yaml").exists() for folder in real_path(output).parents):
        raise BagError(f"--output {output}: lies in a bag, which is left as it is")


def _terminal_table(table: Table) -> TerminalTable:
    """Return the columns that decide, which fit into 80 characters."""
    shown = TerminalTable()
    chosen = [k for k, column in enumerate(table.columns) if column.name in TERMINAL_COLUMNS]
    for column in (table.columns[k] for k in chosen):
        unit = f", {column.unit}" if column.unit else ""
        shown.add_column(column.name + unit, justify="left" if column.text else "right")
    for row in table.rows:
        shown.add_row(*(row.cells[k] for k in chosen))
    return shown
