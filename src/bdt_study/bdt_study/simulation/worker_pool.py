"""Processes of this computer that work on one job after the other, and are replaced if killed."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import chain, islice
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Generic, TypeVar

from bdt_msgs_py.command_errors import LoopError

AHEAD = 2
"""Jobs for each worker that are given out: one in work, and the next one at hand."""

MOST_DEATHS = 5
"""Deaths of workers with no job done in between after which it is no accident."""

Job = TypeVar("Job")
Result = TypeVar("Result")


class WorkerPool(Generic[Job, Result]):
    """Processes that do the same to many jobs.

    Parameters
    ----------
    work : callable
        What is done to a job; a function of a module.
    workers : int, optional
        Number of processes; None for as many as there are cores to run on.
    describe : callable
        Says of a job what it is, in a few words.
    """

    def __init__(
        self,
        work: Callable[[Job], Result],
        workers: int | None = None,
        describe: Callable[[Job], str] = str,
    ) -> None:
        self._work = work
        self._workers = workers or len(os.sched_getaffinity(0))
        self._describe = describe

    def results(self, jobs: Iterator[Job]) -> Iterator[tuple[Job, Result]]:
        """Iterate over jobs with their results as they come, in any order.

        Jobs are asked for as there is room for them; when there are no more, those in work are
        finished. Whoever stops iterating ends the processes at once.

        Raises
        ------
        LoopError
            If workers end again and again. What the work raises comes through as it is.
        """
        for _, job, result in self._numbered_results(jobs):
            yield job, result

    def in_order(self, jobs: Iterator[Job]) -> Iterator[Result]:
        """Iterate over results in the order of the jobs; see :meth:`results`."""
        early: dict[int, Result] = {}
        due = 0
        for number, _, result in self._numbered_results(jobs):
            early[number] = result
            while due in early:
                yield early.pop(due)
                due += 1

    def _numbered_results(self, jobs: Iterator[Job]) -> Iterator[tuple[int, Job, Result]]:
        unfinished: dict[int, Job] = {}
        numbered = enumerate(jobs)
        deaths = 0
        while True:
            again = list(unfinished.items())
            try:
                for number, result in self._worked_on(chain(again, numbered), unfinished):
                    deaths = 0
                    yield number, unfinished.pop(number), result
            except BrokenProcessPool as error:
                deaths += 1
                if deaths > MOST_DEATHS:
                    raise LoopError(
                        f"{deaths} workers ended one after the other, at work on "
                        f"{', '.join(map(self._describe, unfinished.values()))}: is there enough "
                        "memory?"
                    ) from error
            else:
                return

    def _worked_on(
        self, jobs: Iterator[tuple[int, Job]], unfinished: dict[int, Job]
    ) -> Iterator[tuple[int, Result]]:
        """Iterate over results by number of the job; what is given out stands in `unfinished`."""
        # Not forked: the compiled kernels bring threads of their own.
        spawned = get_context("spawn")
        life, end_of_life = spawned.Pipe(duplex=False)
        pool = ProcessPoolExecutor(
            self._workers, mp_context=spawned, initializer=_begin_worker, initargs=(life,)
        )
        numbers: dict[Future[Result], int] = {}
        try:
            while True:
                for number, job in islice(jobs, AHEAD * self._workers - len(numbers)):
                    # Before it is given out: a pool that is broken refuses it.
                    unfinished[number] = job
                    numbers[pool.submit(self._work, job)] = number
                if not numbers:
                    return
                done, _ = wait(numbers, return_when=FIRST_COMPLETED)
                for future in done:
                    yield numbers.pop(future), future.result()
        finally:
            end_of_life.close()
            pool.shutdown(cancel_futures=True)
            life.close()


def _begin_worker(life: Connection) -> None:
    """Leave Ctrl-C to whoever gives out the work, and end when that one does, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def end_with_life() -> None:
        # Nothing is ever sent: this returns when the other end is closed, by whatever.
        life.poll(None)
        os._exit(0)

    threading.Thread(target=end_with_life, daemon=True).start()
