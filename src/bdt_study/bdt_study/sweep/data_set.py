"""The data set of a sweep: a folder with a part for each batch, a row for each run."""

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from bdt_msgs_py.parameter_tables import known_parameters
from bdt_study.engine.part_folder import Identity, PartFolder
from bdt_study.simulation.configured_loop import TABLES
from bdt_study.sweep.batches import cut
from bdt_study.sweep.run_batch import BatchResult
from bdt_study.sweep.run_quantities import quantity_of
from bdt_study.sweep.study import Study

STUDY = "study.json"
"""The study, by which a sweep knows what it goes on with."""
METADATA = b"bdt_sweep"
"""Key of the study in the metadata of a part."""


class DataSet(PartFolder[BatchResult]):
    """The parts of a sweep.

    Parameters
    ----------
    folder : Path
        Folder of the sweep.
    study : Study
        The study.
    """

    def __init__(self, folder: Path, study: Study) -> None:
        self.cutting = cut(study)
        super().__init__(folder, Identity("sweep", STUDY, study.text), self.cutting.count)
        self._schema = part_schema(study)

    def table(self, result: BatchResult) -> Any:
        """Return the rows of a batch."""
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


def _type_of(default: Any) -> Any:
    if isinstance(default, tuple):
        return pa.list_(_type_of(default[0]))
    kinds = {bool: pa.bool_(), int: pa.int64(), str: pa.string()}
    return kinds.get(type(default), pa.float64())
