"""``bdt sweep``: from a study file to a data set that is whole at any moment."""

import argparse
import json
import os
import platform
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rich.console import Console

from bdt_msgs_py.command_errors import INTERRUPTED, BadInputError, LoopError, complain
from bdt_msgs_py.output_files import not_writable
from bdt_msgs_py.stop_signals import StopSignals
from bdt_study.sweep.batches import batches
from bdt_study.sweep.data_set import DataSet, write_whole
from bdt_study.sweep.dry_run import dry_run
from bdt_study.sweep.engine import Engine, LocalWorkers
from bdt_study.sweep.progress import SweepProgress
from bdt_study.sweep.run_batch import Batch
from bdt_study.sweep.study import Study
from bdt_study.sweep.study_file import read_study

SESSIONS = "sessions"
"""Folder with a file for each time that a sweep was started: when, where, with which versions."""
VERSIONS = ("bdt_study", "numpy", "scipy", "numba", "pyarrow")
MOST_WORKERS = 1024


def sweep(options: argparse.Namespace) -> int:
    """Run the command and return its exit code.

    Raises
    ------
    BadInputError
        For options, a study or a folder that are not as they must be.
    LoopError
        If workers or the scheduler are lost.
    """
    study = read_study(options.what)
    _check_workers(options)
    if options.dry_run:
        estimate = dry_run(study, options.workers)
        print(json.dumps(estimate.to_dictionary(), indent=2) if options.json else estimate.text())
        return 0
    output = options.output or Path("sweeps") / study.name
    data = DataSet(output, study)
    engine = _engine(options)
    data.create(resume=options.resume)
    outcome = _Sweep(study, data, engine).run()
    if options.json:
        print(json.dumps(outcome, indent=2))
    if outcome["runs_missing"]:
        return complain(
            f"interrupted: {study.runs - outcome['runs_missing']} of {study.runs} runs are in "
            f"{output}; to go on: bdt sweep {options.what} --output {output} --resume",
            INTERRUPTED,
        )
    if not options.json:
        Console().print(f"{study.runs} runs: {data.parts_folder}", soft_wrap=True, highlight=False)
    return 0


class _Sweep:
    """A sweep from now on: the batches that are missing, worked on and written."""

    def __init__(self, study: Study, data: DataSet, engine: Engine) -> None:
        self._study, self._data, self._engine = study, data, engine

    def run(self) -> dict[str, Any]:
        """Work on what is missing and return what is told of it."""
        missing = self._data.missing()
        cutting = self._data.cutting
        left = sum(last - first for first, last in map(cutting.bounds, missing))
        self._write_session()
        began = time.monotonic()
        with (
            SweepProgress(self._study, self._study.runs - left) as progress,
            StopSignals(progress.end) as signals,
        ):
            for result in self._engine.results(self._until(signals, missing)):
                try:
                    self._data.write(result)
                except OSError as error:
                    raise LoopError(
                        f"{self._data.folder}: cannot be written: {error.strerror or error}; "
                        "what is there is whole: go on with --resume"
                    ) from error
                progress.add(result)
        tally = progress.tally
        return {
            "study": self._study.name,
            "output": str(self._data.folder),
            "runs": self._study.runs,
            "runs_missing": left - tally.runs,
            "runs_now": tally.runs,
            "seconds": round(time.monotonic() - began, 3),
            "now": tally.summary(),
        }

    def _until(self, signals: StopSignals, missing: list[int]) -> Iterator[Batch]:
        """Iterate over the missing batches until somebody wants an end."""
        for batch in batches(self._study, missing):
            if signals.requested:
                return
            yield batch

    def _write_session(self) -> None:
        began = datetime.now(UTC)
        session = {
            "began": began.isoformat(timespec="seconds"),
            "machine": platform.node(),
            "processor": platform.machine(),
            "system": platform.platform(),
            "cores": os.cpu_count(),
            "python": platform.python_version(),
            **{name: version(name) for name in VERSIONS},
        }
        path = self._data.folder / SESSIONS / f"{began:%Y%m%dT%H%M%S%f}.json"
        try:
            path.parent.mkdir(exist_ok=True)
            write_whole(path, (json.dumps(session, indent=2) + "\n").encode())
        except OSError as error:
            raise not_writable("--output", self._data.folder, error) from error


def _check_workers(options: argparse.Namespace) -> None:
    workers = options.workers
    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise BadInputError(f"--workers {workers}: must be 1 to {MOST_WORKERS}")
    if workers is not None and options.scheduler is not None:
        raise BadInputError("--workers: is for this computer, a --scheduler has workers of its own")


def _engine(options: argparse.Namespace) -> Engine:
    if options.scheduler is None:
        return LocalWorkers(options.workers)
    # Nobody needs Dask on a single computer.
    from bdt_study.sweep.dask_cluster import DaskCluster  # noqa: PLC0415

    return DaskCluster(options.scheduler)
