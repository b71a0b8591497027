"""Executors: they wait for what happens and run the callbacks."""

from __future__ import annotations

import concurrent.futures
import os
import threading
import warnings
from collections.abc import Callable
from typing import Any

from embedded_ros.deadline import NEVER, Deadline
from embedded_ros.errors import (
    ConditionReachedException,
    ExternalShutdownException,
    ShutdownException,
    TimeoutException,
)
from embedded_ros.public_names import also_here, shown_in
from rclpy._executor import Executor
from rclpy.context import Context
from rclpy.task import Future

__all__ = [
    "ConditionReachedException",
    "Executor",
    "ExternalShutdownException",
    "MultiThreadedExecutor",
    "ShutdownException",
    "SingleThreadedExecutor",
    "TimeoutException",
]

__getattr__ = also_here(
    __name__,
    {
        "rclpy.client": "Client",
        "rclpy.clock": "Clock ClockType",
        "rclpy.exceptions": "InvalidHandle",
        "rclpy.guard_condition": "GuardCondition",
        "rclpy.service": "Service",
        "rclpy.subscription": "Subscription",
        "rclpy.task": "Task",
        "rclpy.timer": "Timer",
        "rclpy.utilities": "timeout_sec_to_nsec",
    },
)
shown_in(
    __name__,
    ConditionReachedException,
    Executor,
    ExternalShutdownException,
    ShutdownException,
    TimeoutException,
)


def _never() -> bool:
    return False


class SingleThreadedExecutor(Executor):
    """Runs callbacks in the thread that spins."""

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Run one callback, or return after a timeout.

        Parameters
        ----------
        timeout_sec : float, optional
            None or negative: for ever; 0: do not wait.
        """
        deadline = NEVER if timeout_sec is None else Deadline(timeout_sec)
        work = self._embedded.next(deadline, _never)
        if work is not None:
            self._embedded.run(work)

    def spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Run one callback, or return when a future is done or after a timeout."""
        with future._waking(self._embedded.interrupt):
            work = self._embedded.next(Deadline(timeout_sec), future.done)
        if work is not None:
            self._embedded.run(work)


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
        if num_threads == 1:
            warnings.warn(
                "MultiThreadedExecutor is used with a single thread.\n"
                "Use the SingleThreadedExecutor instead.",
                stacklevel=2,
            )
        self.__threads = concurrent.futures.ThreadPoolExecutor(
            len(os.sched_getaffinity(0)) if num_threads is None else num_threads
        )
        self.__started: list[concurrent.futures.Future[None]] = []

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Start one callback, or return after a timeout.

        Parameters
        ----------
        timeout_sec : float, optional
            None or negative: for ever; 0: do not wait.
        """
        self.__start(Deadline(timeout_sec), _never)

    def spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Start one callback, or return when a future is done or after a timeout."""
        with future._waking(self._embedded.interrupt):
            self.__start(Deadline(timeout_sec), future.done)

    def __start(self, deadline: Deadline, is_enough: Callable[[], bool]) -> None:
        try:
            work = self._embedded.next(deadline, lambda: is_enough() or self.__has_failed())
        except ExternalShutdownException:
            return  # this executor only returns, as in rclpy
        if work is not None:
            started = self.__threads.submit(self._embedded.run, work)
            self.__started.append(started)
            # Once it is done, not before: whoever spins asks whether it has failed.
            started.add_done_callback(self.__wake_for_failure)
        ended = [started for started in self.__started if started.done()]
        self.__started = [started for started in self.__started if started not in ended]
        for each in ended:
            each.result()  # raises what the callback raised

    def __wake_for_failure(self, started: concurrent.futures.Future[None]) -> None:
        if not started.cancelled() and started.exception() is not None:
            self._embedded.interrupt()

    def __has_failed(self) -> bool:
        return any(started.done() and started.exception() for started in self.__started)

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Stop running callbacks, wait for those that run and end the threads.

        Called in a callback it does not wait, as that would be for itself.
        """
        super().shutdown(timeout_sec)
        self.__threads.shutdown(wait=False, cancel_futures=True)
        if threading.current_thread() in self.__threads._threads:
            return True
        left = Deadline(timeout_sec).seconds_left()
        # One that never began is cancelled, and nobody would tell of that.
        begun = [started for started in self.__started if not started.cancelled()]
        return not concurrent.futures.wait(begun, left).not_done
