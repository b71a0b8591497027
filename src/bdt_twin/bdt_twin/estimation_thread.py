"""Estimation beside the node: telemetry keeps coming in while a window is worked on."""

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_twin.decider import Decider, no_decider
from bdt_twin.decision import Decision
from bdt_twin.estimator import Estimate, Estimator, TelemetryRejectedError
from bdt_twin.machine_recollection import MachineRecollection
from bdt_twin.user_estimator import UserEstimatorError

LARGEST_BACKLOG = 5.0
"""Telemetry that may wait [s] before the estimator takes all of it in one go.

Well above what a plant in lockstep runs ahead, whose results may not depend on the computer.
"""

LONGEST_END = 5.0
"""Wall time [s] that an estimator may take to its end; one that hangs never comes to it."""


class Outcome(NamedTuple):
    """What came of one batch, or of several that had to wait.

    Attributes
    ----------
    newest : float
        Time of the newest sample [s].
    samples : int
        Number of samples in the newest batch.
    estimate : Estimate or None
        The estimate that became due.
    fault : str
        Why the estimator rejected the batch; empty if it did not.
    error : str
        How somebody's estimator failed, with its file and line; empty if it did not.
    is_hole : bool
        True for what stands for a batch of no use, which was rejected before.
    begins : bool
        True if this is another run.
    seconds : float
        Wall time that it took [s].
    decision : Decision or None
        What was decided for the estimate; None without one, and for eq. 9.
    machine : MachineRecollection or None
        What is worth keeping of the machine; None from an estimator that does not look at it.
    """

    newest: float
    samples: int
    estimate: Estimate | None
    fault: str
    error: str
    is_hole: bool
    begins: bool
    seconds: float
    decision: Decision | None = None
    machine: MachineRecollection | None = None


class _Batch(NamedTuple):
    rows: NDArray[np.float64]
    is_hole: bool
    begins: bool


class EstimationThread:
    """An estimator in a thread of its own.

    Parameters
    ----------
    estimator : Estimator
        Used by this thread only.
    notify : callable
        Called in the thread when there are outcomes to collect.
    decider : Decider
        Decides by simulation, in this thread as well; by default nothing does.
    """

    def __init__(
        self,
        estimator: Estimator,
        notify: Callable[[], object],
        decider: Decider = no_decider,
    ) -> None:
        self._estimator = estimator
        self._decider = decider
        self._notify = notify
        self._waiting: deque[_Batch] = deque()
        self._outcomes: deque[Outcome] = deque()
        self._last_time = -np.inf
        self._failure: BaseException | None = None
        self._ended = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="estimation", daemon=True)
        self._thread.start()

    def put(self, batch: NDArray[np.float64], *, begins: bool = False) -> None:
        """Hand over the next batch.

        Parameters
        ----------
        batch : ndarray, shape (n, 3)
            Telemetry rows (t [s], u [V], q3 [m]), n at least 1.
        begins : bool
            Whether another run begins with it, so that the estimator forgets everything.
        """
        self._put(_Batch(batch, is_hole=False, begins=begins))

    def put_hole(self, batch: NDArray[np.float64]) -> None:
        """Hand over a batch of which the times alone are known, so that estimators go across it."""
        rows = np.full(batch.shape, np.nan)
        rows[:, 0] = batch[:, 0]
        self._put(_Batch(rows, is_hole=True, begins=False))

    def _put(self, batch: _Batch) -> None:
        with self._changed:
            self._waiting.append(batch)
            self._changed.notify()

    def outcomes(self) -> list[Outcome]:
        """Return what came of the batches since the last call, in their order.

        Raises whatever an estimator of this package raised that was not about its data.
        """
        with self._changed:
            if self._failure is not None:
                raise self._failure
            collected = list(self._outcomes)
            self._outcomes.clear()
        return collected

    def close(self) -> None:
        """End the thread once the window is done that it works on; leave one that hangs alone."""
        with self._changed:
            self._ended = True
            self._changed.notify()
        self._thread.join(LONGEST_END)

    def _run(self) -> None:
        try:
            while (batches := self._next()) is not None:
                outcome = self._work_on(batches)
                with self._changed:
                    self._outcomes.append(outcome)
                self._notify()
        # Whatever it is, it belongs to whoever collects outcomes; a thread has nobody to tell.
        except BaseException as error:  # noqa: BLE001
            with self._changed:
                self._failure = error
            self._notify()

    def _next(self) -> list[_Batch] | None:
        """Wait for telemetry: the oldest batch, or those of one kind that have waited too long."""
        with self._changed:
            self._changed.wait_for(lambda: self._waiting or self._ended)
            if self._ended:
                return None
            late = self._waiting[-1].rows[-1, 0] - self._waiting[0].rows[0, 0] > LARGEST_BACKLOG
            batches = [self._waiting.popleft()]
            while late and self._waiting and not _is_bound(batches[0], self._waiting[0]):
                batches.append(self._waiting.popleft())
            return batches

    def _work_on(self, batches: list[_Batch]) -> Outcome:
        began = time.perf_counter()
        first, newest = batches[0], batches[-1]
        rows = first.rows if len(batches) == 1 else np.concatenate([one.rows for one in batches])
        begins = first.begins or bool(rows[0, 0] < self._last_time)
        if first.begins:
            self._estimator.restart()
        estimate, fault, failure, decision = None, "", "", None
        try:
            estimate = self._estimator.update(rows, newest_only=len(batches) > 1)
            decision = self._decider(rows, estimate, begins=begins)
        except TelemetryRejectedError as error:
            fault = str(error)
        except UserEstimatorError as error:
            failure = str(error)
        if np.isfinite(rows[-1, 0]):
            self._last_time = float(rows[-1, 0])
        return Outcome(
            self._last_time,
            len(newest.rows),
            estimate,
            fault,
            failure,
            first.is_hole,
            begins,
            time.perf_counter() - began,
            decision,
            getattr(self._estimator, "recollection", None),
        )


def _is_bound(first: _Batch, following: _Batch) -> bool:
    """Tell whether two batches cannot be worked on together."""
    return first.is_hole or following.is_hole or following.begins
