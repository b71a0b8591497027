"""The data set of a sweep: a folder of Parquet files, a part for each batch, whole at any moment.

A part gets its name when it is whole, so whoever reads the folder sees finished runs only, and
what a killed program was writing is not there.
"""

import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from pyarrow import parquet

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.folder_sync import create_folder, sync_folder
from bdt_msgs_py.output_files import not_writable
from bdt_msgs_py.parameter_tables import known_parameters
from bdt_study.simulation.configured_loop import TABLES
from bdt_study.sweep.batches import BatchCut, cut
from bdt_study.sweep.run_batch import BatchResult
from bdt_study.sweep.run_quantities import quantity_of
from bdt_study.sweep.study import Study

PARTS = "runs"
"""Folder of the parts within that of a sweep."""
STUDY = "study.json"
"""The study, by which a sweep knows what it goes on with."""
METADATA = b"bdt_sweep"
"""Key of the study in the metadata of a part."""
UNFINISHED = ".tmp"


class DataSet:
    """The parts of a sweep.

    Parameters
    ----------
    folder : Path
        Folder of the sweep.
    study : Study
        The study.
    """

    def __init__(self, folder: Path, study: Study) -> None:
        self.folder = folder
        self.parts_folder = folder / PARTS
        self._study = study
        self._schema = part_schema(study)

    @property
    def cutting(self) -> BatchCut:
        """How the study is cut into parts."""
        return cut(self._study)

    def create(self, *, resume: bool) -> None:
        """Create the folder, or take up what is there.

        Parameters
        ----------
        resume : bool
            Whether parts that are there count.

        Raises
        ------
        BadInputError
            If the folder holds something else, another study, or runs that nobody wants to resume.
        """
        label = f"--output {self.folder}"
        known = self.folder / STUDY
        try:
            if known.exists():
                self._check_study(known, label)
                if not resume:
                    raise BadInputError(f"{label}: already holds this sweep: go on with --resume")
            elif self.folder.exists() and not _is_empty(self.folder):
                raise BadInputError(
                    f"{label}: holds something that is no sweep, must be a new or empty folder"
                )
            create_folder(self.folder)
            if not known.exists():
                # Before all else: by this a sweep is known, however soon it is killed.
                write_whole(known, self._study.text.encode() + b"\n")
            create_folder(self.parts_folder)
            for left in self.parts_folder.glob(f"*{UNFINISHED}"):
                left.unlink()
        except OSError as error:
            raise not_writable("--output", self.folder, error) from error

    def missing(self) -> list[int]:
        """Return the numbers of the batches that have no part yet."""
        there = {path.name for path in self.parts_folder.glob("*.parquet")}
        return [number for number in range(self.cutting.count) if part_name(number) not in there]

    def write(self, result: BatchResult) -> None:
        """Write the part of a batch.

        Raises
        ------
        OSError
            If it cannot be written; nothing of it is left then.
        """
        path = self.parts_folder / part_name(result.number)
        sink = pa.BufferOutputStream()
        parquet.write_table(self._table(result), sink, compression="zstd")
        write_whole(path, sink.getvalue().to_pybytes())

    def _table(self, result: BatchResult) -> Any:
        points = result.points
        count = len(points.seeds)
        columns: list[Any] = [
            list(range(points.first, points.first + count)),
            points.repetitions,
            points.seeds,
            *points.columns,
        ]
        arrays = [
            pa.array(values, field.type)
            for values, field in zip(columns, self._schema, strict=False)
        ]
        # Unknown is empty: a spreadsheet and SQL know no NaN.
        arrays += [
            pa.array(column, pa.float64(), mask=np.isnan(column)) for column in result.values.T
        ]
        return pa.Table.from_arrays(arrays, schema=self._schema)

    def _check_study(self, known: Path, label: str) -> None:
        text = known.read_text(encoding="utf-8").strip()
        if text == self._study.text:
            return
        try:
            other = json.loads(text)
            differing = [
                key for key, value in json.loads(self._study.text).items() if other[key] != value
            ]
        except (ValueError, KeyError, TypeError) as error:
            raise BadInputError(f"{label}: its {STUDY} cannot be read") from error
        raise BadInputError(
            f"{label}: is the data set of another study or version, which differs in "
            f"{', '.join(differing)}"
        )


def _is_empty(folder: Path) -> bool:
    """Tell whether there is nothing but what a killed sweep left of its first file."""
    return folder.is_dir() and not [
        path for path in folder.iterdir() if path.name != f"{STUDY}{UNFINISHED}"
    ]


def part_schema(study: Study) -> Any:
    """Return the schema of the parts: run, repetition, seed, parameters, quantities."""
    fields = [
        ("run", pa.int64(), "number of the run, for bdt sweep replay"),
        ("repetition", pa.int32(), "which of the runs with these parameters"),
        ("seed", pa.int64(), "seed of the sensor's noise and of the link"),
    ]
    for axis in study.axes:
        node, _, flat = axis.name.partition(".")
        default, described = known_parameters(TABLES[node])[flat]
        kind = _type_of(default)
        unit = f" [{described.unit}]" if described.unit else ""
        fields.append((axis.name, kind, f"{described.description}{unit}"))
    fields += [(name, pa.float64(), quantity_of(name).description) for name in study.compute]
    return pa.schema(
        [pa.field(name, kind, metadata={"description": text}) for name, kind, text in fields],
        metadata={METADATA: study.text.encode()},
    )


def part_name(number: int) -> str:
    """Return the name of the part of a batch."""
    return f"part-{number:07d}.parquet"


def write_whole(path: Path, content: bytes) -> None:
    """Write a file that is whole once it has its name, also after a power cut.

    Raises
    ------
    OSError
        If it cannot be written; nothing of it is left then.
    """
    unfinished = path.with_name(f"{path.name}{UNFINISHED}")
    try:
        with unfinished.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(path)
    except BaseException:
        with suppress(OSError):
            unfinished.unlink()
        raise
    sync_folder(path.parent)


def _type_of(default: Any) -> Any:
    if isinstance(default, tuple):
        return pa.list_(_type_of(default[0]))
    kinds = {bool: pa.bool_(), int: pa.int64(), str: pa.string()}
    return kinds.get(type(default), pa.float64())
