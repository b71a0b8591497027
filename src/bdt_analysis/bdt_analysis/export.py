"""Figures and signals of a run as files for other tools: PNG, SVG, CSV, Parquet."""

import csv
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, fields
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from bdt_analysis.figures.figure_style import write_png, write_svg
from bdt_analysis.metrics.reconfigurations import Reconfiguration, reconfiguration_log
from bdt_analysis.metrics.step_analysis import StepSummary
from bdt_analysis.re_estimation.re_estimation import ReEstimation
from bdt_bags.bag_error import BagError
from bdt_bags.reading.recording import Recording
from bdt_msgs_py.topics import TELEMETRY_COLUMNS, TRUTH_COLUMNS

FORMATS = ("png", "svg", "csv", "parquet")
"""What can be exported: the figures as pictures, the signals as tables."""

FOLDER = "export"
"""Folder of the exports within that of the report."""

RE_ESTIMATE_COLUMNS = ("t[s]", "gap[rad]", "standard_uncertainty[rad]", "error[rad]")


@dataclass(frozen=True)
class SignalTable:
    """A table to export.

    Attributes
    ----------
    name : str
        Name of its file, without the suffix.
    columns : sequence of str
        Quantities with their units.
    data : sequence of sequence
        One sequence of values for each column.
    """

    name: str
    columns: Sequence[str]
    data: Sequence[Sequence[Any]]


def checked_formats(text: str) -> tuple[str, ...]:
    """Return the formats that a comma-separated list names.

    Raises
    ------
    BagError
        For a name that is none of :data:`FORMATS`, and for Parquet without a pyarrow that works.
    """
    names = tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    for name in names or ("",):
        if name not in FORMATS:
            raise BagError(f"--export {name!r}: must be of {', '.join(FORMATS)}, with commas")
    if "parquet" in names:
        _check_pyarrow()
    return names


def _check_pyarrow() -> None:
    """Refuse Parquet where pyarrow is missing or, too new for this numpy, cannot be imported."""
    try:
        import_module("pyarrow.parquet")
    except (ImportError, AttributeError, ValueError) as error:
        raise BagError(f"--export parquet: needs the Python package pyarrow: {error}") from error


def signal_tables(
    recording: Recording, steps: Sequence[StepSummary], re_estimation: ReEstimation | None = None
) -> list[SignalTable]:
    """Return the signals of a run, all samples of them, with the stamps of the bag.

    Parameters
    ----------
    recording : Recording
        The run.
    steps : sequence of StepSummary
        Its steps.
    re_estimation : ReEstimation, optional
        What an estimator made of its telemetry.

    Returns
    -------
    list of SignalTable
        Telemetry, truth (if the bag has it), reference, estimates with their uncertainties (if the
        twin tells them), dead zones, re-estimates (if there are any), reconfigurations, steps.
        What is not a number is unknown. Times are on the clock of the
        telemetry, a clock that counts from 1970 included.
    """
    origin = recording.time_origin

    def rows(name: str, columns: Sequence[str], array: Any) -> SignalTable:
        columns_data = [array[:, 0] + origin, *array.T[1:]]
        return SignalTable(name, columns, [column.tolist() for column in columns_data])

    tables = [rows("telemetry", TELEMETRY_COLUMNS, recording.telemetry)]
    if recording.truth is not None:
        tables.append(rows("truth", TRUTH_COLUMNS, recording.truth))
    tables += [
        rows("reference", ("t[s]", "r[m]"), recording.reference),
        rows("estimates", ("t[s]", "gap[rad]"), recording.estimates[:, :2]),
        rows("dead_zones", ("t[s]", "dead_zone[m]"), recording.dead_zones),
    ]
    if len(recording.uncertainties):
        heads = ("t[s]", "standard_uncertainty[rad]")
        tables.append(rows("uncertainties", heads, recording.uncertainties))
    if re_estimation is not None:
        stated = re_estimation.estimates
        columns = (stated.time, stated.gap, stated.uncertainty, stated.error)
        tables.append(rows("re_estimates", RE_ESTIMATE_COLUMNS, np.column_stack(columns)))
    names = [field.name for field in fields(StepSummary)]
    values = [list(column) for column in zip(*(astuple(step) for step in steps), strict=True)]
    if values:
        start = names.index("t_start_s")
        values[start] = [time + origin for time in values[start]]
    log = [
        (entry.time_s + origin, *entry[1:3], _later(entry.estimate_time_s, origin), *entry[4:])
        for entry in reconfiguration_log(recording)
    ]
    cells = [list(column) for column in zip(*log, strict=True)]
    cells = cells or [[] for _ in Reconfiguration._fields]
    tables.append(SignalTable("reconfigurations", Reconfiguration._fields, cells))
    tables.append(SignalTable("steps", names, values or [[] for _ in names]))
    return tables


def _later(time: float | None, origin: float) -> float | None:
    return None if time is None else time + origin


def export(
    folder: Path,
    formats: Sequence[str],
    recording: Recording,
    steps: Sequence[StepSummary],
    figures: dict[str, Figure],
    re_estimation: ReEstimation | None = None,
) -> list[Path]:
    """Write figures and signals.

    Parameters
    ----------
    folder : Path
        Folder, created if necessary.
    formats : sequence of str
        From :func:`checked_formats`.
    recording : Recording
        The run.
    steps : sequence of StepSummary
        Its steps.
    figures : dict of str to Figure
        Figures by the names of their files.
    re_estimation : ReEstimation, optional
        What an estimator made of the telemetry.

    Returns
    -------
    list of Path
        What was written.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    folder.mkdir(exist_ok=True)
    draw = {"png": write_png, "svg": write_svg}
    write = {"csv": _write_csv, "parquet": _write_parquet}
    written = []
    for name in formats:
        if name in draw:
            for stem, figure in figures.items():
                written.append(folder / f"{stem}.{name}")
                draw[name](figure, written[-1])
        else:
            writer: Callable[[SignalTable, Path], None] = write[name]
            for table in signal_tables(recording, steps, re_estimation):
                written.append(folder / f"{table.name}.{name}")
                writer(table, written[-1])
    return written


def _write_csv(table: SignalTable, path: Path) -> None:
    """Write a header and rows; numbers have the digits that give the same float again."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(table.columns)
        writer.writerows(zip(*table.data, strict=True))


def _write_parquet(table: SignalTable, path: Path) -> None:
    # Optional: a report needs no Parquet.
    import pyarrow as pa  # noqa: PLC0415
    import pyarrow.parquet as pq  # noqa: PLC0415

    arrays = [pa.array(column, type=_arrow_type(column)) for column in table.data]
    pq.write_table(pa.table(arrays, names=list(table.columns)), path, compression="zstd")


def _arrow_type(column: Sequence[Any]) -> str:
    """Return the type of a column, also of one that is empty or all unknown."""
    known = next((value for value in column if value is not None), 0.0)
    return "bool" if isinstance(known, bool) else "float64"
