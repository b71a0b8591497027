"""Trials in a folder of Parquet files, a row for each, that anybody can read."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
from pyarrow import dataset

from bdt_msgs_py.command_errors import BadInputError
from bdt_study.engine.job import Engine
from bdt_study.engine.job_progress import JobProgress
from bdt_study.engine.kept_results import keep_results
from bdt_study.engine.part_folder import Identity, PartFolder
from bdt_study.engine.session import write_session
from bdt_study.evaluation.trial import Trial
from bdt_study.evaluation.trial_job import Evaluation, FinishedTrial, Twin

NUMBERS = pa.list_(pa.float64())


class TrialColumn(NamedTuple):
    """A column that holds a field of a trial.

    Attributes
    ----------
    name : str
        Its name.
    kind : pyarrow.DataType
        Type of its values.
    field : str
        Name of the field.
    meaning : str
        What it is.
    unknown : float
        What an empty place in a list stands for: spreadsheets know neither NaN nor infinity.
    """

    name: str
    kind: Any
    field: str
    meaning: str
    unknown: float = math.nan


WHICH = (
    ("case", pa.string(), "name of the case"),
    ("estimator", pa.string(), "estimator of the twin"),
    ("decision", pa.string(), "how the twin decides on dead zone and gains"),
    ("seed", pa.int64(), "number of the scenario"),
)
"""Columns that tell what was tried."""

COLUMNS = (
    TrialColumn("errors_rad", NUMBERS, "errors", "estimated less true gap at each estimate"),
    TrialColumn(
        "uncertainties_rad",
        NUMBERS,
        "uncertainties",
        "standard uncertainties that the estimator stated; empty where it stated none",
    ),
    TrialColumn(
        "bounds_rad",
        NUMBERS,
        "bounds",
        "Cramér-Rao bounds of the gap's standard deviation, of some of the windows",
    ),
    TrialColumn(
        "bound_errors_rad", NUMBERS, "bound_errors", "errors of the estimates from these windows"
    ),
    TrialColumn("window_times_s", NUMBERS, "window_times", "processor time of each estimate"),
    TrialColumn("limit_cycles", pa.int64(), "limit_cycles", "steps that end in a limit cycle"),
    TrialColumn(
        "worst_bias_percent",
        pa.float64(),
        "worst_bias",
        "largest bias of all steps, of the amplitude",
    ),
    TrialColumn(
        "avoidable_limit_cycles",
        pa.int64(),
        "avoidable_limit_cycles",
        "steps with a limit cycle that have none with the true gap as dead zone",
    ),
    TrialColumn(
        "avoidable_steps",
        pa.int64(),
        "avoidable_steps",
        "steps without a limit cycle with the true gap as dead zone",
    ),
    TrialColumn(
        "settling_times_s",
        NUMBERS,
        "settling_times",
        "settling time of each step; empty for one that does not settle",
        math.inf,
    ),
    TrialColumn("taken_back", pa.int64(), "taken_back", "simulated decisions that were taken back"),
    TrialColumn(
        "pushed_steps",
        pa.int64(),
        "pushed_steps",
        "steps that something pushed while they were judged; in no other column",
    ),
    TrialColumn(
        "pushed_limit_cycles",
        pa.int64(),
        "pushed_limit_cycles",
        "those of them that are taken for a limit cycle",
    ),
    TrialColumn(
        "pushed_with_true_gap",
        pa.int64(),
        "pushed_with_true_gap",
        "the same with the true gap as dead zone",
    ),
)
"""Columns that tell what came out: all fields of a trial."""

SCHEMA = pa.schema(
    [
        pa.field(name, kind, metadata={"description": meaning})
        for name, kind, meaning in (
            *WHICH,
            *((column.name, column.kind, column.meaning) for column in COLUMNS),
        )
    ]
)


class TrialFolder(PartFolder[FinishedTrial]):
    """The trials of an evaluation that there are.

    Parameters
    ----------
    folder : Path
        The folder.
    evaluation : Evaluation
        The evaluation.
    """

    def __init__(self, folder: Path, evaluation: Evaluation) -> None:
        identity = Identity("evaluation", "evaluation.json", evaluation.text)
        super().__init__(folder, identity, evaluation.trials)
        self._seeds = evaluation.seeds

    def table(self, result: FinishedTrial) -> Any:
        """Return the row of a trial."""
        which = (result.case, *result.twin, result.seed)
        arrays = [pa.array([value], kind) for value, (_, kind, _) in zip(which, WHICH, strict=True)]
        arrays += [_array(getattr(result.trial, column.field), column) for column in COLUMNS]
        return pa.Table.from_arrays(arrays, schema=SCHEMA)

    def finished(self) -> Iterator[FinishedTrial]:
        """Iterate over the trials of the evaluation that there are, in any order.

        Those of scenarios that it does not ask for are left out.

        Raises
        ------
        BadInputError
            If a part cannot be read.
        """
        try:
            parts = dataset.dataset(self.parts_folder, format="parquet", schema=SCHEMA)
            table = parts.to_table().combine_chunks()
        except (OSError, pa.ArrowInvalid) as error:
            raise BadInputError(f"{self.parts_folder}: cannot be read: {error}") from error
        for row in range(table.num_rows):
            case, kind, decision, seed = (table[name][row].as_py() for name, _, _ in WHICH)
            if seed not in self._seeds:
                continue
            fields = {column.field: _field(table[column.name][row], column) for column in COLUMNS}
            yield FinishedTrial(case, Twin(kind, decision), seed, Trial(**fields))


def keep_trials(
    evaluation: Evaluation, engine: Engine, output: Path, *, resume: bool
) -> list[FinishedTrial]:
    """Run the trials that a folder lacks and return those that it holds then.

    Parameters
    ----------
    evaluation : Evaluation
        The evaluation.
    engine : Engine
        What works on it.
    output : Path
        The folder.
    resume : bool
        Whether trials that are there already count.

    Returns
    -------
    list of FinishedTrial
        Fewer than the evaluation has after Ctrl-C.

    Raises
    ------
    BadInputError
        If the folder holds something else or cannot be written, or an estimator of the user's
        fails.
    LoopError
        If workers are lost or the disk is full.
    """
    folder = TrialFolder(output, evaluation)
    folder.create(resume=resume)
    write_session(output)
    missing = folder.missing()
    progress = JobProgress("closed-loop runs", evaluation.trials, evaluation.trials - len(missing))

    def keep(number: int, trial: FinishedTrial) -> None:
        folder.write(number, trial)
        progress.add(1)

    keep_results(engine, evaluation.jobs(missing), keep, progress, output)
    return list(folder.finished())


def _array(value: Any, column: TrialColumn) -> Any:
    """Return a column with the field of one trial."""
    if column.kind != NUMBERS:
        return pa.array([value], column.kind)
    is_unknown = np.isnan(value) if math.isnan(column.unknown) else value == column.unknown
    return pa.ListArray.from_arrays([0, len(value)], pa.array(value, pa.float64(), mask=is_unknown))


def _field(cell: Any, column: TrialColumn) -> Any:
    """Return the field of a trial that stands in a cell."""
    if column.kind != NUMBERS:
        return cell.as_py()
    return cell.values.fill_null(column.unknown).to_numpy(zero_copy_only=False)
