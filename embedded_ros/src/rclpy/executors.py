"""Executors: they wait for what happens and run the callbacks."""

from __future__ import annotations

import concurrent.futures
import os
import threading
import time
import warnings
from collections.abc import Callable
from types import TracebackType
from typing import Any

from embedded_ros import cyclone, interrupts
from embedded_ros.callback_running import CallbackRunning
from embedded_ros.readiness import Work
from rclpy.context import Context
from rclpy.exceptions import NotInitializedException
from rclpy.task import Future
from rclpy.utilities import get_default_context, timeout_sec_to_nsec

__all__ = [
    "ConditionReachedException",
    "Executor",
    "ExternalShutdownException",
    "MultiThreadedExecutor",
    "ShutdownException",
    "SingleThreadedExecutor",
    "TimeoutException",
]


class TimeoutException(Exception):
    """Nothing happened in time."""


class ShutdownException(Exception):
    """The executor is shut down."""


class ExternalShutdownException(Exception):
    """The context was shut down while the executor waited."""


class ConditionReachedException(Exception):
    """The future to wait for is done."""


def _never() -> bool:
    return False


class Executor(CallbackRunning):
    """Base of the executors.

    Parameters
    ----------
    context : Context, optional
        The default context by default.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        self._context = get_default_context() if context is None else context
        session = self._context.handle
        if session is None:
            raise NotInitializedException("cannot create an executor")
        self._init_readiness(session)
        session.register(self)
        if session.valid:
            # The context may come from another thread, which cannot set this up.
            interrupts.watch(session)
        self._context.on_shutdown(self.wake)

    @property
    def context(self) -> Context:
        """Context of the executor."""
        return self._context

    def shutdown(self, timeout_sec: float | None = None) -> bool:  # noqa: ARG002
        """Stop running callbacks and let go of the nodes.

        Parameters
        ----------
        timeout_sec : float, optional
            How long to wait for callbacks that run in other threads; for ever by default. Here
            there are none: see :class:`MultiThreadedExecutor`.

        Returns
        -------
        bool
            False if some still run.
        """
        self._is_shutdown = True
        self._guard.set()
        with self._nodes_lock:
            self._nodes = []
            self._wait_set.close()
            self._guard.close()
            self._attached = {}
            self._timers = []
        self._ready.clear()
        return True

    def spin(self) -> None:
        """Run callbacks until the context or the executor is shut down.

        Raises
        ------
        ExternalShutdownException
            If the context is shut down while this waits.
        """
        while self._context.ok() and not self._is_shutdown:
            self.spin_once()

    def spin_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Run callbacks until a future is done or a timeout is over."""
        future.add_done_callback(lambda _: self.interrupt())
        deadline = None
        if timeout_sec is not None and timeout_sec >= 0:
            deadline = time.monotonic() + timeout_sec
        while self._context.ok() and not future.done() and not self._is_shutdown:
            left = None if deadline is None else max(0.0, deadline - time.monotonic())
            self.spin_once_until_future_complete(future, left)
            if deadline is not None and time.monotonic() >= deadline:
                return

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run one callback, or return after a timeout.

        Parameters
        ----------
        timeout_sec : float, optional
            None or negative: for ever; 0: do not wait.
        """
        raise NotImplementedError

    def spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Run one callback, or return when a future is done or after a timeout."""
        raise NotImplementedError

    def __enter__(self) -> Executor:
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_val: BaseException | None,
        exc_tb: TracebackType | None,
    ) -> None:
        self.shutdown()

    # ------------------------------------------------------------------ waiting

    def _next_work(
        self, timeout_sec: float | None, condition: Callable[[], bool] = _never
    ) -> Work | None:
        """Wait for something to do; None if the time is over, or the condition or shutdown came."""
        timeout = timeout_sec_to_nsec(timeout_sec)
        deadline = None if timeout < 0 else time.monotonic_ns() + timeout
        while not self._is_shutdown and not condition():
            if self._tasks:
                return self._tasks.popleft()
            while self._ready:
                entity = self._ready.popleft()
                taken = self._claim(entity)
                if taken is not None:
                    return entity, taken
            if self._entities_changed:
                self._update_wait_set()
            left = cyclone.INFINITE if deadline is None else deadline - time.monotonic_ns()
            wait = self._shortened(left)
            fired = self._wait_set.wait(wait)
            if self._guard.ref in fired:
                # Before the looks at what it may have been set for: the next wait would miss it.
                self._guard.clear()
            if self._is_shutdown:
                return None
            if not self._context.ok():
                raise ExternalShutdownException
            self._note_ready(fired, timers_too=wait == 0 or not fired)
            if self._yielded:
                self._tasks.extend(self._yielded)
                self._yielded.clear()
            if left <= 0 and not self._ready and not self._tasks:
                return None
        return None


class SingleThreadedExecutor(Executor):
    """Runs callbacks in the thread that spins."""

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run one callback, or return after a timeout.

        Parameters
        ----------
        timeout_sec : float, optional
            None or negative: for ever; 0: do not wait.
        """
        work = self._next_work(timeout_sec)
        if work is not None:
            self._run(work)

    def spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Run one callback, or return when a future is done or after a timeout."""
        work = self._next_work(timeout_sec, future.done)
        if work is not None:
            self._run(work)


class MultiThreadedExecutor(Executor):
    """Runs callbacks in a pool of threads.

    Parameters
    ----------
    num_threads : int, optional
        As many as the process may use processors by default.
    context : Context, optional
        The default context by default.
    """

    def __init__(self, num_threads: int | None = None, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        if num_threads is None:
            num_threads = len(os.sched_getaffinity(0))
        if num_threads == 1:
            warnings.warn(
                "MultiThreadedExecutor is used with a single thread.\n"
                "Use the SingleThreadedExecutor instead.",
                stacklevel=2,
            )
        self._pool = concurrent.futures.ThreadPoolExecutor(num_threads)
        self._running: list[concurrent.futures.Future[None]] = []

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Start one callback, or return after a timeout.

        Parameters
        ----------
        timeout_sec : float, optional
            None or negative: for ever; 0: do not wait.
        """
        self._start_work(timeout_sec, _never)

    def spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Start one callback, or return when a future is done or after a timeout."""
        self._start_work(timeout_sec, future.done)

    def _start_work(self, timeout_sec: float | None, condition: Callable[[], bool]) -> None:
        try:
            work = self._next_work(timeout_sec, lambda: condition() or self._has_failed())
        except ExternalShutdownException:
            return  # this executor only returns, as in rclpy
        if work is not None:
            self._running.append(self._pool.submit(self._run_and_report, work))
        for running in [running for running in self._running if running.done()]:
            self._running.remove(running)
            running.result()  # raises what the callback raised

    def _run_and_report(self, work: Work) -> None:
        try:
            self._run(work)
        except BaseException:
            self.interrupt()
            raise

    def _has_failed(self) -> bool:
        return any(running.done() and running.exception() for running in self._running)

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Stop running callbacks, wait for those that run and end the threads.

        Called in a callback it does not wait, as that would be for itself.
        """
        super().shutdown(timeout_sec)
        self._pool.shutdown(wait=False, cancel_futures=True)
        if threading.current_thread() in self._pool._threads:
            return True
        timeout = None if timeout_sec is None or timeout_sec < 0 else timeout_sec
        return not concurrent.futures.wait(self._running, timeout).not_done
