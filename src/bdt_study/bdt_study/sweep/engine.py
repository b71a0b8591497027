"""What works on batches: processes of this computer, or whatever else has the same method."""

from collections.abc import Iterator
from typing import Protocol

from bdt_study.simulation.worker_pool import WorkerPool
from bdt_study.sweep.run_batch import Batch, BatchResult, run_batch


class Engine(Protocol):
    """Works on batches."""

    def results(self, batches: Iterator[Batch]) -> Iterator[BatchResult]:
        """Iterate over the results as they come, in any order.

        Batches are asked for as there is room for them; when there are no more, those in work
        are finished.

        Raises
        ------
        BadInputError
            If a run cannot be made.
        LoopError
            If workers end again and again.
        """


class LocalWorkers:
    """Processes of this computer, in place of which new ones come if they are killed.

    Parameters
    ----------
    workers : int, optional
        Number of processes; None for as many as there are cores to run on.
    """

    def __init__(self, workers: int | None = None) -> None:
        self._pool = WorkerPool(run_batch, workers, lambda batch: f"part {batch.number}")

    def results(self, batches: Iterator[Batch]) -> Iterator[BatchResult]:
        """Iterate over the results as they come; see :class:`Engine`."""
        for _, result in self._pool.results(batches):
            yield result
