"""A data set read again: its study, and its runs as columns of numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from pyarrow import compute, dataset

from bdt_msgs_py.command_errors import BadInputError
from bdt_study.engine.part_folder import PARTS
from bdt_study.sweep.data_set import STUDY
from bdt_study.sweep.study import Study, study_from_text

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SweepTable:
    """The runs of a sweep that there are.

    Attributes
    ----------
    study : Study
        The study.
    runs : ndarray, shape (n,)
        Their numbers, increasing.
    columns : dict
        Parameters and quantities, arrays of shape (n,); NaN for what is unknown. Words and truth
        values are told apart by their place among the values of the axis.
    """

    study: Study
    runs: NDArray[np.int64]
    columns: dict[str, FloatArray]


def open_study(folder: Path) -> Study:
    """Return the study of a data set.

    Raises
    ------
    BadInputError
        If the folder holds no sweep.
    """
    try:
        return study_from_text((folder / STUDY).read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInputError(f"{folder}: holds no sweep: {error.strerror or error}") from error
    except ValueError as error:
        raise BadInputError(f"{folder / STUDY}: cannot be read: {error}") from error


def read_runs(folder: Path, study: Study) -> SweepTable:
    """Return all runs of a data set that there are.

    Parameters
    ----------
    folder : Path
        Folder of the sweep.
    study : Study
        Its study.

    Raises
    ------
    BadInputError
        If there is none, or a part cannot be read.
    """
    names = ["run", *(axis.name for axis in study.axes), *study.compute]
    table = _read(folder, columns=names).sort_by("run")
    if not table.num_rows:
        raise BadInputError(f"{folder}: has no runs yet")
    columns = {
        axis.name: _numbers(table.column(axis.name), axis.values if axis.is_grid else ())
        for axis in study.axes
    }
    columns |= {name: _numbers(table.column(name), ()) for name in study.compute}
    return SweepTable(study, table.column("run").to_numpy(), columns)


def read_run(folder: Path, run: int) -> dict[str, Any]:
    """Return one row of a data set by the names of its columns.

    Raises
    ------
    BadInputError
        If the run is not there.
    """
    rows = _read(folder, filter=compute.field("run") == run).to_pylist()
    if not rows:
        raise BadInputError(f"{folder}: has no run {run}")
    return dict(rows[0])


def _read(folder: Path, **options: Any) -> pa.Table:
    try:
        return dataset.dataset(folder / PARTS, format="parquet").to_table(**options)
    except (OSError, pa.ArrowInvalid) as error:
        raise BadInputError(f"{folder / PARTS}: cannot be read: {error}") from error


def _numbers(column: Any, values: Sequence[Any]) -> FloatArray:
    """Return a column as numbers; of one that has none the places among the values of its axis."""
    if not is_numeric(values):
        places = {value: float(place) for place, value in enumerate(values)}
        items = column.to_pylist()
        return np.array([places[tuple(item) if isinstance(item, list) else item] for item in items])
    numbers: FloatArray = column.cast(pa.float64()).to_numpy()
    return numbers


def is_numeric(values: Sequence[Any]) -> bool:
    """Tell whether values of an axis are numbers; those of a distribution are."""
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)
