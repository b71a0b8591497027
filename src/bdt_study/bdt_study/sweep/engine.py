"""What works on batches: processes of this computer, or whatever else has the same method."""

import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import chain, islice
from multiprocessing import get_context, parent_process
from typing import Protocol

from bdt_msgs_py.command_errors import LoopError
from bdt_study.sweep.run_batch import Batch, BatchResult, run_batch

AHEAD = 2
"""Batches for each worker that are given out: one in work, and the next one at hand."""

MOST_DEATHS = 5
"""Deaths of workers with no batch done in between after which it is no accident."""


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


class WorkerPool:
    """Processes of this computer, in place of which new ones come if they are killed.

    Parameters
    ----------
    workers : int, optional
        Number of processes; None for as many as there are cores to run on.
    """

    def __init__(self, workers: int | None = None) -> None:
        self._workers = workers or len(os.sched_getaffinity(0))

    def results(self, batches: Iterator[Batch]) -> Iterator[BatchResult]:
        """Iterate over the results as they come; see :class:`Engine`."""
        unfinished: dict[int, Batch] = {}
        deaths = 0
        while True:
            again = list(unfinished.values())
            with self._new_pool() as pool:
                try:
                    for result in self._worked_on(pool, chain(again, batches), unfinished):
                        deaths = 0
                        yield result
                except BrokenProcessPool as error:
                    deaths += 1
                    if deaths > MOST_DEATHS:
                        raise LoopError(
                            f"{deaths} workers ended one after the other, at work on parts "
                            f"{', '.join(map(str, sorted(unfinished)))}: is there enough memory?"
                        ) from error
                else:
                    return
                finally:
                    pool.shutdown(wait=False, cancel_futures=True)

    def _worked_on(
        self,
        pool: ProcessPoolExecutor,
        batches: Iterator[Batch],
        unfinished: dict[int, Batch],
    ) -> Iterator[BatchResult]:
        """Iterate over results; what is given out and not done stands in `unfinished`."""
        futures: set[Future[BatchResult]] = set()
        while True:
            for batch in islice(batches, AHEAD * self._workers - len(futures)):
                # Before it is given out: a pool that is broken refuses it.
                unfinished[batch.number] = batch
                futures.add(pool.submit(run_batch, batch))
            if not futures:
                return
            done, futures = wait(futures, return_when=FIRST_COMPLETED)
            for result in [future.result() for future in done]:
                del unfinished[result.number]
                yield result

    def _new_pool(self) -> ProcessPoolExecutor:
        # Not forked: the compiled kernels bring threads of their own.
        return ProcessPoolExecutor(
            self._workers, mp_context=get_context("spawn"), initializer=_begin_worker
        )


def _begin_worker() -> None:
    """Leave Ctrl-C to whoever gives out the work, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = parent_process()
    if parent is not None:

        def end_with_parent() -> None:
            parent.join()
            os._exit(1)

        threading.Thread(target=end_with_parent, daemon=True).start()
