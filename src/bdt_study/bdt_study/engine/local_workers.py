"""Processes of this computer that work on one job after the other, and are replaced if killed."""

import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import chain, islice
from multiprocessing import get_context
from multiprocessing.connection import Connection

from bdt_msgs_py.command_errors import LoopError
from bdt_study.engine.job import AHEAD, MOST_DEATHS, Engine, Job, Result


class LocalWorkers(Engine):
    """Processes of this computer, which start with the first job and stay until the end.

    Parameters
    ----------
    workers : int, optional
        Number of processes; None for as many as there are cores to run on.
    """

    def __init__(self, workers: int | None = None) -> None:
        self._count = workers or len(os.sched_getaffinity(0))
        self._processes: _Processes | None = None

    def end(self) -> None:
        """End the processes, whatever they have in work."""
        if self._processes is not None:
            self._processes.end()
            self._processes = None

    def results(self, jobs: Iterator[Job[Result]]) -> Iterator[tuple[int, Result]]:
        """Iterate over results; see :meth:`bdt_study.engine.job.Engine.results`.

        Whoever stops iterating ends the processes at once.
        """
        unfinished: dict[int, Job[Result]] = {}
        deaths = 0
        while True:
            again = list(unfinished.values())
            try:
                for number, result in self._worked_on(chain(again, jobs), unfinished):
                    deaths = 0
                    del unfinished[number]
                    yield number, result
            except BrokenProcessPool as error:
                deaths += 1
                if deaths > MOST_DEATHS:
                    raise LoopError(
                        f"{deaths} workers ended one after the other, at work on "
                        f"{', '.join(job.name for job in unfinished.values())}: is there enough "
                        "memory?"
                    ) from error
            else:
                return

    def _worked_on(
        self, jobs: Iterator[Job[Result]], unfinished: dict[int, Job[Result]]
    ) -> Iterator[tuple[int, Result]]:
        """Iterate over results by number of the job; what is given out stands in `unfinished`."""
        if self._processes is None:
            self._processes = _Processes(self._count)
        pool = self._processes.pool
        numbers: dict[Future[Result], int] = {}
        try:
            while True:
                for job in islice(jobs, AHEAD * self._count - len(numbers)):
                    # Before it is given out: a pool that is broken refuses it.
                    unfinished[job.number] = job
                    numbers[pool.submit(job.run)] = job.number
                if not numbers:
                    return
                done, _ = wait(numbers, return_when=FIRST_COMPLETED)
                for future in done:
                    yield numbers.pop(future), future.result()
        except BaseException:
            # Nobody waits for what is in work any more.
            self.end()
            raise


class _Processes:
    """A pool whose processes end with it, however it ends."""

    def __init__(self, count: int) -> None:
        # Not forked: the compiled kernels bring threads of their own.
        spawned = get_context("spawn")
        self._life, self._end_of_life = spawned.Pipe(duplex=False)
        self.pool = ProcessPoolExecutor(
            count, mp_context=spawned, initializer=_begin_worker, initargs=(self._life,)
        )

    def end(self) -> None:
        self._end_of_life.close()
        self.pool.shutdown(cancel_futures=True)
        self._life.close()


def _begin_worker(life: Connection) -> None:
    """Leave Ctrl-C to whoever gives out the work, and end when that one does, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def end_with_life() -> None:
        # Nothing is ever sent: this returns when the other end is closed, by whatever.
        life.poll(None)
        os._exit(0)

    threading.Thread(target=end_with_life, daemon=True).start()
