"""Workers of a Dask scheduler in place of processes of this computer: one machine or many."""

from collections.abc import Iterator
from itertools import chain, islice
from queue import Empty, SimpleQueue

from distributed import CancelledError, Client, Future, KilledWorker
from distributed.comm.core import CommClosedError

from bdt_msgs_py.command_errors import BadInputError, LoopError
from bdt_study.simulation.worker_pool import AHEAD, MOST_DEATHS
from bdt_study.sweep.run_batch import Batch, BatchResult, run_batch

PATIENCE = 10.0
"""Time in which a scheduler has to answer [s]."""
LOOK = 2.0
"""Time from one look at the scheduler to the next where no batch is done [s]."""


class DaskCluster:
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
        self._done: SimpleQueue[Future[BatchResult]] = SimpleQueue()
        try:
            self._client = Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, TimeoutError, ValueError, TypeError) as error:
            raise BadInputError(f"--scheduler {address}: no scheduler answers there") from error

    def results(self, batches: Iterator[Batch]) -> Iterator[BatchResult]:
        """Iterate over the results as they come; see :class:`bdt_study.sweep.engine.Engine`."""
        given: dict[Future[BatchResult], Batch] = {}
        deaths: dict[int, int] = {}
        again: list[Batch] = []
        with self._client:
            while True:
                room = max(self._threads() * AHEAD, AHEAD) - len(given)
                for batch in islice(chain(_taken(again), batches), max(room, 0)):
                    given[self._submitted(batch)] = batch
                if not given:
                    return
                future = self._next_done()
                batch = given.pop(future)
                try:
                    yield self._result(future)
                except KilledWorker as error:
                    deaths[batch.number] = deaths.get(batch.number, 0) + 1
                    if deaths[batch.number] > MOST_DEATHS:
                        raise LoopError(
                            f"part {batch.number}: all workers that had it in work ended"
                        ) from error
                    again.append(batch)

    def _submitted(self, batch: Batch) -> Future[BatchResult]:
        # Not pure: what is asked for twice is to be computed twice.
        future = self._client.submit(run_batch, batch, pure=False)
        future.add_done_callback(self._done.put)
        return future

    def _next_done(self) -> Future[BatchResult]:
        while True:
            try:
                return self._done.get(timeout=LOOK)
            except Empty:
                self._look()

    def _result(self, future: Future[BatchResult]) -> BatchResult:
        while True:
            try:
                result: BatchResult = future.result(timeout=PATIENCE)
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
        """Return how many batches the workers can have in work."""
        try:
            return sum(self._client.nthreads().values())
        except (OSError, TimeoutError) as error:
            raise self._lost() from error

    def _look(self) -> None:
        if self._client.status != "running":
            raise self._lost()

    def _lost(self) -> LoopError:
        return LoopError(
            f"the scheduler {self._address} is gone; what is there is whole: go on with --resume"
        )


def _taken(waiting: list[Batch]) -> Iterator[Batch]:
    """Iterate over what waits, which is taken away."""
    while waiting:
        yield waiting.pop(0)
