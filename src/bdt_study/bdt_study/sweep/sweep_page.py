"""The page of a sweep: one file with everything in it, interactive where there is a browser."""

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from bdt_analysis.figures.embedding import packed_text
from bdt_analysis.figures.interactive import plotly_library
from bdt_analysis.pages.rendering import render_page
from bdt_analysis.pages.table import Column, Row, Table, number
from bdt_study.sweep.margins import LIKELY, Margin
from bdt_study.sweep.sweep_answers import QuantityMap, SweepAnswers

DIGITS = ".4g"


def sweep_page(answers: SweepAnswers, folder: Path) -> str:
    """Return the page as text.

    Parameters
    ----------
    answers : SweepAnswers
        What is told.
    folder : Path
        Folder of the sweep, for the commands that replay a run.
    """
    study, runs = answers.table.study, answers.table.runs.size
    library = plotly_library()
    return render_page(
        "sweep.html",
        "bdt_study.sweep",
        name=study.name,
        headline=_headline(answers),
        good=answers.cycles is not None and not answers.cycles.hits[0],
        runs=runs,
        of=study.runs,
        study=study,
        plotly=None if library is None else packed_text(library),
        description=page_description(answers),
        margins=_margin_table(answers.margins),
        worst=_worst_table(answers, folder),
    )


def page_description(answers: SweepAnswers) -> dict[str, Any]:
    """Return what the plots of the page show, for JSON."""
    return {
        "axes": [
            {"name": axis.name, "unit": axis.unit, "values": axis.values, "paper": axis.paper}
            for axis in answers.axes
        ],
        "maps": [_map(one) for one in answers.maps],
        "indices": [asdict(one) for one in answers.indices],
    }


def _map(one: QuantityMap) -> dict[str, Any]:
    told: dict[str, Any] = {
        "quantity": one.quantity,
        "axes": list(one.axes),
        "values": _json(one.values.tolist()),
    }
    if one.shares is not None:
        told |= {
            "low": _json(one.shares.low.tolist()),
            "high": _json(one.shares.high.tolist()),
            "counts": one.shares.counts.tolist(),
        }
    return told


def _headline(answers: SweepAnswers) -> str:
    cycles = answers.cycles
    if cycles is None:
        return f"{answers.table.runs.size} runs"
    share, low, high = (100.0 * float(one[0]) for one in (cycles.shares, cycles.low, cycles.high))
    return f"A limit cycle in {share:.3g} % of the runs ({low:.3g} to {high:.3g} %)"


def _margin_table(margins: list[Margin]) -> Table:
    columns = [
        Column("parameter", text=True),
        Column("paper's value"),
        Column("safe from"),
        Column("safe to"),
        Column("below it"),
        Column("above it"),
    ]
    rows = [
        Row(
            [
                one.parameter,
                number(one.point, DIGITS),
                number(one.lowest, DIGITS),
                number(one.highest, DIGITS),
                _beyond(one.lowest, reached=one.reaches_low),
                _beyond(one.highest, reached=one.reaches_high),
            ],
            alarm=one.lowest is None,
        )
        for one in margins
    ]
    return Table(
        "margins",
        "Margins around the paper's loop",
        columns,
        rows,
        note=f"Safe is where at most {100 * LIKELY:g} % of the runs have a limit cycle, with the "
        "other parameters of the grid at the values next to the paper's.",
        empty="The paper's values are not among those that were tried.",
    )


def _beyond(end: float | None, *, reached: bool) -> str:
    if end is None:
        return ""
    return "not tried" if reached else "unsafe"


def _worst_table(answers: SweepAnswers, folder: Path) -> Table:
    study = answers.table.study
    names = [*(axis.name for axis in study.axes), *study.compute]
    columns = [Column("run"), *(Column(name) for name in names), Column("replay", text=True)]
    rows = [
        Row(
            [
                str(run),
                *(number(_known(values[name]), DIGITS) for name in names),
                f"bdt sweep replay {folder} {run}",
            ]
        )
        for run, values in answers.worst
    ]
    return Table("worst", "Worst runs", columns, rows)


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _json(values: Any) -> Any:
    """Return nested lists without what JSON does not know."""
    if isinstance(values, list):
        return [_json(value) for value in values]
    return _known(values)
