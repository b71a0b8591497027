"""``bdt sweep``: from a study file to a data set that is whole at any moment."""

import argparse
import json
import time
from pathlib import Path
from typing import Any

from rich.console import Console

from bdt_msgs_py.command_errors import INTERRUPTED, complain
from bdt_study.engine.chosen_engine import check_workers, chosen_engine
from bdt_study.engine.job import Engine
from bdt_study.engine.job_progress import JobProgress
from bdt_study.engine.kept_results import keep_results
from bdt_study.engine.session import write_session
from bdt_study.sweep.batches import batches
from bdt_study.sweep.data_set import DataSet
from bdt_study.sweep.dry_run import dry_run
from bdt_study.sweep.run_batch import BatchResult
from bdt_study.sweep.study import Study
from bdt_study.sweep.study_file import read_study
from bdt_study.sweep.tally import Tally


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
    check_workers(options.workers, options.scheduler)
    if options.dry_run:
        estimate = dry_run(study, options.workers)
        print(json.dumps(estimate.to_dictionary(), indent=2) if options.json else estimate.text())
        return 0
    output = options.output or Path("sweeps") / study.name
    data = DataSet(output, study)
    with chosen_engine(options.workers, options.scheduler) as engine:
        data.create(resume=options.resume)
        outcome = _work(study, data, engine)
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


def _work(study: Study, data: DataSet, engine: Engine) -> dict[str, Any]:
    """Work on the batches that are missing and return what is told of it."""
    missing = data.missing()
    left = sum(last - first for first, last in map(data.cutting.bounds, missing))
    tally = Tally(study.compute)
    progress = JobProgress(study.name, study.runs, study.runs - left)

    def keep(number: int, result: BatchResult) -> None:
        data.write(number, result)
        tally.add(result)
        progress.add(len(result.values), tally.line())

    write_session(data.folder)
    began = time.monotonic()
    keep_results(engine, batches(study, missing), keep, progress, data.folder)
    return {
        "study": study.name,
        "output": str(data.folder),
        "runs": study.runs,
        "runs_missing": left - tally.runs,
        "runs_now": tally.runs,
        "seconds": round(time.monotonic() - began, 3),
        "now": tally.summary(),
    }
