"""Workers of a Dask scheduler in place of processes of this computer: one machine or many."""

from collections.abc import Iterator
from importlib.metadata import version
from itertools import chain, islice
from queue import Empty, SimpleQueue
from typing import TypeVar

from distributed import CancelledError, Client, Future, KilledWorker
from distributed.comm.core import CommClosedError

from bdt_msgs_py.command_errors import BadInputError, LoopError
from bdt_study.engine.job import AHEAD, MOST_DEATHS, Engine, Job, Result

PATIENCE = 10.0
"""Time in which a scheduler has to answer [s]."""
LOOK = 2.0
"""Time from one look at the scheduler to the next where no job is done [s]."""
PACKAGE = "bdt_study"

Item = TypeVar("Item")


class DaskCluster(Engine):
    """The workers of a scheduler.

    Workers may come and go; what one of them had in work another one gets.

    Parameters
    ----------
    address : str
        Address of the scheduler, e.g. ``tcp://10.0.0.1:8786``.

    Raises
    ------
    BadInputError
        If no scheduler answers there.
    """

    def __init__(self, address: str) -> None:
        self._address = address
        try:
            self._client = Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, TimeoutError, ValueError, TypeError) as error:
            raise BadInputError(f"--scheduler {address}: no scheduler answers there") from error

    def end(self) -> None:
        """Leave the scheduler, which drops what is not done."""
        self._client.close()

    def results(self, jobs: Iterator[Job[Result]]) -> Iterator[tuple[int, Result]]:
        """Iterate over results; see :meth:`bdt_study.engine.job.Engine.results`."""
        finished: SimpleQueue[Future[Result]] = SimpleQueue()
        given: dict[Future[Result], Job[Result]] = {}
        deaths: dict[int, int] = {}
        again: list[Job[Result]] = []
        while True:
            room = max(self._threads() * AHEAD, AHEAD) - len(given)
            for job in islice(chain(_taken(again), jobs), max(room, 0)):
                # Not pure: what is asked for twice is to be computed twice.
                future = self._client.submit(run_on_worker, job, version(PACKAGE), pure=False)
                given[future] = job
                future.add_done_callback(finished.put)
            if not given:
                return
            future = self._next_of(finished)
            job = given.pop(future)
            try:
                yield job.number, self._result(future)
            except KilledWorker as error:
                deaths[job.number] = deaths.get(job.number, 0) + 1
                if deaths[job.number] > MOST_DEATHS:
                    raise LoopError(f"{job.name}: all workers that had it in work ended") from error
                again.append(job)

    def _next_of(self, finished: SimpleQueue[Future[Result]]) -> Future[Result]:
        while True:
            try:
                return finished.get(timeout=LOOK)
            except Empty:
                self._look()

    def _result(self, future: Future[Result]) -> Result:
        while True:
            try:
                result: Result = future.result(timeout=PATIENCE)
            except (BadInputError, KilledWorker):
                raise
            except TimeoutError:
                # A result whose worker has ended since is computed once more.
                self._look()
            except (CancelledError, CommClosedError) as error:
                raise self._lost() from error
            # Whatever else a worker raises is about what is installed there.
            except Exception as error:
                raise LoopError(f"a worker failed: {type(error).__name__}: {error}") from error
            else:
                future.release()
                return result

    def _threads(self) -> int:
        """Return how many jobs the workers can have in work."""
        try:
            return sum(self._client.nthreads().values())
        except (OSError, TimeoutError) as error:
            raise self._lost() from error

    def _look(self) -> None:
        if self._client.status != "running":
            raise self._lost()

    def _lost(self) -> LoopError:
        return LoopError(f"the scheduler {self._address} is gone")


def run_on_worker(job: Job[Result], asked_by: str) -> Result:
    """Return what a job gives, in a process of whatever installation.

    Parameters
    ----------
    job : Job
        The job.
    asked_by : str
        Version of this package where the result is wanted.

    Raises
    ------
    BadInputError
        If this process has another version: results would not belong together.
    """
    here = version(PACKAGE)
    if asked_by != here:
        raise BadInputError(
            f"a worker has {PACKAGE} {here}, the program that asks has {asked_by}: must be the same"
        )
    return job.run()


def _taken(waiting: list[Item]) -> Iterator[Item]:
    """Iterate over what waits, which is taken away."""
    while waiting:
        yield waiting.pop(0)
