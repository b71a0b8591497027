"""What a sweep will take: runs, time and room, measured on a few of its runs."""

import os
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from bdt_study.engine.part_folder import part_name
from bdt_study.sweep.batches import batches
from bdt_study.sweep.data_set import DataSet
from bdt_study.sweep.run_batch import Batch
from bdt_study.sweep.run_points import RunPoints
from bdt_study.sweep.study import Study

LONGEST = 1.0
"""Time after which no more runs are tried [s]."""


@dataclass(frozen=True)
class SweepEstimate:
    """What a sweep will take.

    Attributes
    ----------
    runs, parts : int
        Runs, and files in which they will be.
    workers : int
        Processes that were reckoned with.
    seconds_per_run : float
        Time of a run on one core of this computer [s].
    seconds : float
        Time of the sweep on this computer [s].
    bytes : int
        Room on the disk.
    """

    runs: int
    parts: int
    workers: int
    seconds_per_run: float
    seconds: float
    bytes: int

    def to_dictionary(self) -> dict[str, Any]:
        """Return it for JSON."""
        return asdict(self)

    def text(self) -> str:
        """Return it in a line."""
        return (
            f"{self.runs} runs in {self.parts} parts: about {_duration(self.seconds)} with "
            f"{self.workers} workers here ({1e3 * self.seconds_per_run:.3g} ms a run), "
            f"{self.bytes / 1e6:.3g} MB"
        )


def dry_run(study: Study, workers: int | None = None) -> SweepEstimate:
    """Try runs that are spread over the study for about a second.

    Parameters
    ----------
    study : Study
        The study.
    workers : int, optional
        Processes to reckon with; None for as many as there are cores.
    """
    workers = workers or len(os.sched_getaffinity(0))
    points = RunPoints(study)

    def run(number: int) -> None:
        Batch(0, study, points.between(number, number + 1)).run()

    run(0)  # compiles
    tried, began = 0, time.perf_counter()
    while (taken := time.perf_counter() - began) < LONGEST and tried < study.runs:
        run(tried * 7919 % study.runs)
        tried += 1
    each = taken / tried
    with tempfile.TemporaryDirectory() as folder:
        data = DataSet(Path(folder), study)
        data.create(resume=False)
        whole = next(batches(study, [0]))
        some = Batch(0, study, points.between(0, min(tried, len(whole.points.seeds)))).run()
        data.write(0, some)
        size = (data.parts_folder / part_name(0)).stat().st_size
    parts = data.cutting.count
    room = size * max(parts, round(study.runs / len(some.values)))
    return SweepEstimate(study.runs, parts, workers, each, each * study.runs / workers, room)


def _duration(seconds: float) -> str:
    if seconds < 100.0:
        return f"{seconds:.2g} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 6000.0 else f"{seconds / 3600.0:.3g} h"
