"""Estimation beside the node: telemetry keeps coming in while a window is worked on."""

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_twin.estimator import Estimate, Estimator, TelemetryRejectedError

PATIENCE = 5.0
"""Telemetry that may wait [s] before the estimator takes all of it in one go.

Well above what a plant in lockstep runs ahead, whose results may not depend on the computer.
"""


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
    begins : bool
        True if time went back, so that this is another run.
    seconds : float
        Wall time that it took [s].
    """

    newest: float
    samples: int
    estimate: Estimate | None
    fault: str
    begins: bool
    seconds: float


class EstimationThread:
    """An estimator in a thread of its own.

    Parameters
    ----------
    estimator : Estimator
        Used by this thread only.
    notify : callable
        Called in the thread when there are outcomes to collect.
    """

    def __init__(self, estimator: Estimator, notify: Callable[[], object]) -> None:
        self._estimator = estimator
        self._notify = notify
        self._waiting: deque[NDArray[np.float64]] = deque()
        self._outcomes: deque[Outcome] = deque()
        self._last_time = -np.inf
        self._failure: BaseException | None = None
        self._ended = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="estimation", daemon=True)
        self._thread.start()

    def put(self, batch: NDArray[np.float64]) -> None:
        """Hand over telemetry rows (t [s], u [V], q3 [m]), shape (n, 3), with n at least 1."""
        with self._changed:
            self._waiting.append(batch)
            self._changed.notify()

    def outcomes(self) -> list[Outcome]:
        """Return what came of the batches since the last call, in their order.

        Raises whatever the estimator raised that was not about its data.
        """
        with self._changed:
            if self._failure is not None:
                raise self._failure
            collected = list(self._outcomes)
            self._outcomes.clear()
        return collected

    def close(self) -> None:
        """End the thread once the window is done that it works on."""
        with self._changed:
            self._ended = True
            self._changed.notify()
        self._thread.join()

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

    def _next(self) -> list[NDArray[np.float64]] | None:
        """Wait for telemetry: the oldest batch, or all of them when they have waited too long."""
        with self._changed:
            self._changed.wait_for(lambda: self._waiting or self._ended)
            if self._ended:
                return None
            late = self._waiting[-1][-1, 0] - self._waiting[0][0, 0] > PATIENCE
            batches = list(self._waiting) if late else [self._waiting.popleft()]
            if late:
                self._waiting.clear()
            return batches

    def _work_on(self, batches: list[NDArray[np.float64]]) -> Outcome:
        began = time.perf_counter()
        rows = batches[0] if len(batches) == 1 else np.concatenate(batches)
        # False for a time that is not a number, which the estimator rejects.
        begins = bool(rows[0, 0] < self._last_time)
        estimate, fault = None, ""
        try:
            estimate = self._estimator.update(rows, newest_only=len(batches) > 1)
        except TelemetryRejectedError as error:
            fault = str(error)
        if np.isfinite(rows[-1, 0]):
            self._last_time = float(rows[-1, 0])
        return Outcome(
            self._last_time,
            len(batches[-1]),
            estimate,
            fault,
            begins,
            time.perf_counter() - began,
        )
