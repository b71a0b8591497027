"""Executors: they wait for what happens and run the callbacks."""

from __future__ import annotations

import concurrent.futures
import os
import threading
import warnings
from collections.abc import Callable, Coroutine, Iterable, Iterator
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Any, Protocol

from embedded_ros import interrupts
from embedded_ros.deadline import NEVER, Deadline
from embedded_ros.embedded_node import EmbeddedNode
from embedded_ros.entity_registry import Kind
from embedded_ros.errors import (
    ConditionReachedException,
    ExternalShutdownException,
    NotInitializedException,
    ShutdownException,
    TimeoutException,
)
from embedded_ros.public_names import also_here, shown_in
from embedded_ros.task_running import TaskRunningLoop
from embedded_ros.work_loop import Job, Source
from rclpy.context import Context
from rclpy.task import Future, Task
from rclpy.utilities import get_default_context

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
        "rclpy.timer": "Timer",
        "rclpy.utilities": "timeout_sec_to_nsec",
    },
)
shown_in(
    __name__,
    ConditionReachedException,
    ExternalShutdownException,
    ShutdownException,
    TimeoutException,
)


class _Node(Protocol):
    """What an executor needs of a node."""

    _embedded: EmbeddedNode

    @property
    def executor(self) -> Executor | None: ...

    @executor.setter
    def executor(self, new_executor: Executor | None) -> None: ...


def _never() -> bool:
    return False


class Executor(AbstractContextManager["Executor"]):
    """Base of the executors; a context manager that shuts the executor down.

    Parameters
    ----------
    context : Context, optional
        The default context by default.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        self._of_context = context or get_default_context()
        session = self._of_context.handle
        if session is None:
            raise NotInitializedException("cannot create an executor")
        self._served: list[Any] = []
        self._chosen: list[Any] | None = None
        self._work = TaskRunningLoop(session, self._sources)
        session.register(self._work)
        if session.valid:
            # The context may come from another thread, which cannot set this up.
            interrupts.watch(session)
        self._of_context.on_shutdown(self.wake)

    @property
    def context(self) -> Context:
        """Context of the executor."""
        return self._of_context

    # ------------------------------------------------------------------ nodes and tasks

    def get_nodes(self) -> list[Any]:
        """Nodes whose callbacks are run."""
        return self._served.copy()

    def add_node(self, node: _Node) -> bool:
        """Run the callbacks of a node; False if that is done already."""
        if node in self._served:
            return False
        self._served.append(node)
        node.executor = self
        self.wake()
        return True

    def remove_node(self, node: _Node) -> None:
        """Run the callbacks of a node no more."""
        if node in self._served:
            self._served.remove(node)
            self.wake()

    def _sources(self) -> Iterator[Any]:
        """All that can have work: events first, then node by node."""
        nodes = tuple(self._served if self._chosen is None else self._chosen)
        for node in nodes:
            yield from node._embedded.registry.of(Kind.EVENTS)
        for node in nodes:
            yield from node._embedded.registry.sources()

    def wake(self) -> None:
        """Look at the nodes again: an entity was made or destroyed."""
        self._work.look_again()

    def create_task(
        self, callback: Callable[..., Any] | Coroutine[Any, Any, Any], *args: Any, **kwargs: Any
    ) -> Task:
        """Have a function or coroutine run, with arguments.

        Returns
        -------
        Task
            Future of the result.
        """
        return self._work.create_task(callback, *args, **kwargs)

    def can_execute(self, entity: Any) -> bool:
        """Tell whether the callback group of an entity lets its callback run now."""
        group = entity.callback_group
        return group is None or bool(group.can_execute(entity))

    # ------------------------------------------------------------------ spinning

    def spin(self) -> None:
        """Run callbacks until the context or the executor is shut down.

        Raises
        ------
        ExternalShutdownException
            If the context is shut down while this waits.
        """
        while not self._work.is_closed and self._of_context.ok():
            self.spin_once()

    def spin_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Run callbacks until a future is done or a timeout is over."""
        deadline = Deadline(timeout_sec)
        while not (future.done() or self._work.is_closed) and self._of_context.ok():
            self.spin_once_until_future_complete(future, deadline.seconds_left())
            if deadline.is_over():
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

    def wait_for_ready_callbacks(
        self,
        timeout_sec: float | None = None,
        nodes: Iterable[_Node] | None = None,
        condition: Callable[[], bool] = _never,
    ) -> tuple[Task, Any, Any]:
        """Wait for a callback to run; for executors that decide themselves where to.

        Parameters
        ----------
        timeout_sec : float, optional
            None or negative: for ever; 0: do not wait.
        nodes : iterable of Node, optional
            Whose callbacks; those of all nodes of the executor by default.
        condition : callable, optional
            Ends the wait when it returns true; asked at the beginning and after each callback.

        Returns
        -------
        Task
            Call it to run the callback.
        entity, node
            Whose callback it is; None for a task.

        Raises
        ------
        TimeoutException, ShutdownException, ExternalShutdownException, ConditionReachedException
        """
        chosen = None if nodes is None else list(nodes)
        if chosen != self._chosen:
            self._chosen = chosen
            self.wake()
        work = self._work.next(Deadline(timeout_sec), condition)
        if isinstance(work, Task):
            return work, None, None
        if work is not None:
            task = Task(self._work.run, (work,), executor=self._work)
            return task, work[0], self._node_of(work[0])
        if self._work.is_closed:
            raise ShutdownException
        if condition():
            raise ConditionReachedException
        raise TimeoutException

    def _node_of(self, source: Source) -> Any:
        for node in self._served:
            registry = node._embedded.registry
            if source in (*registry.of(Kind.EVENTS), *registry.sources()):
                return node
        return None

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
        self._served.clear()
        self._work.close()
        return True

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.shutdown()


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
        work = self._work.next(deadline, _never)
        if work is not None:
            self._work.run(work)

    def spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Run one callback, or return when a future is done or after a timeout."""
        with future._waking(self._work.interrupt):
            work = self._work.next(Deadline(timeout_sec), future.done)
        if work is not None:
            self._work.run(work)


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
        self._threads = concurrent.futures.ThreadPoolExecutor(
            len(os.sched_getaffinity(0)) if num_threads is None else num_threads
        )
        self._started: list[concurrent.futures.Future[None]] = []

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Start one callback, or return after a timeout.

        Parameters
        ----------
        timeout_sec : float, optional
            None or negative: for ever; 0: do not wait.
        """
        self._start(Deadline(timeout_sec), _never)

    def spin_once_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Start one callback, or return when a future is done or after a timeout."""
        with future._waking(self._work.interrupt):
            self._start(Deadline(timeout_sec), future.done)

    def _start(self, deadline: Deadline, is_enough: Callable[[], bool]) -> None:
        try:
            work = self._work.next(deadline, lambda: is_enough() or self._has_failed())
        except ExternalShutdownException:
            return  # this executor only returns, as in rclpy
        if work is not None:
            self._started.append(self._threads.submit(self._run, work))
        ended = [started for started in self._started if started.done()]
        self._started = [started for started in self._started if started not in ended]
        for each in ended:
            each.result()  # raises what the callback raised

    def _run(self, work: Job | Task) -> None:
        try:
            self._work.run(work)
        except BaseException:
            # Whoever spins raises it, too.
            self._work.interrupt()
            raise

    def _has_failed(self) -> bool:
        return any(started.done() and started.exception() for started in self._started)

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Stop running callbacks, wait for those that run and end the threads.

        Called in a callback it does not wait, as that would be for itself.
        """
        super().shutdown(timeout_sec)
        self._threads.shutdown(wait=False, cancel_futures=True)
        if threading.current_thread() in self._threads._threads:
            return True
        left = Deadline(timeout_sec).seconds_left()
        return not concurrent.futures.wait(self._started, left).not_done
