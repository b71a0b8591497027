"""What all executors have in common."""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Iterable, Iterator
from contextlib import AbstractContextManager
from types import TracebackType
from typing import Any, Protocol

from embedded_ros import interrupts
from embedded_ros.deadline import Deadline
from embedded_ros.embedded_node import EmbeddedNode
from embedded_ros.entity_registry import Kind
from embedded_ros.errors import (
    ConditionReachedException,
    NotInitializedException,
    ShutdownException,
    TimeoutException,
)
from embedded_ros.task_running import TaskRunningLoop
from embedded_ros.work_loop import Source
from rclpy.context import Context
from rclpy.task import Future, Task
from rclpy.utilities import get_default_context

__all__ = ["Executor"]


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
        self.__context = context or get_default_context()
        session = self.__context.handle
        if session is None:
            raise NotInitializedException("cannot create an executor")
        self.__nodes: list[Any] = []
        self.__chosen: list[Any] | None = None
        self._embedded = TaskRunningLoop(session, self.__sources)
        session.register(self._embedded)
        if session.valid:
            # The context may come from another thread, which cannot set this up.
            interrupts.watch(session)
        self.__context.on_shutdown(self.wake)

    @property
    def context(self) -> Context:
        """Context of the executor."""
        return self.__context

    # ------------------------------------------------------------------ nodes and tasks

    def get_nodes(self) -> list[Any]:
        """Nodes whose callbacks are run."""
        return self.__nodes.copy()

    def add_node(self, node: _Node) -> bool:
        """Run the callbacks of a node; False if that is done already."""
        if node in self.__nodes:
            return False
        self.__nodes.append(node)
        node.executor = self
        self.wake()
        return True

    def remove_node(self, node: _Node) -> None:
        """Run the callbacks of a node no more."""
        if node in self.__nodes:
            self.__nodes.remove(node)
            self.wake()

    def __sources(self) -> Iterator[Any]:
        """All that can have work: events first, then node by node."""
        nodes = tuple(self.__nodes if self.__chosen is None else self.__chosen)
        for node in nodes:
            yield from node._embedded.registry.of(Kind.EVENTS)
        for node in nodes:
            yield from node._embedded.registry.sources()

    def wake(self) -> None:
        """Look at the nodes again: an entity was made or destroyed."""
        self._embedded.look_again()

    def create_task(
        self, callback: Callable[..., Any] | Coroutine[Any, Any, Any], *args: Any, **kwargs: Any
    ) -> Task:
        """Have a function or coroutine run, with arguments.

        Returns
        -------
        Task
            Future of the result.
        """
        return self._embedded.create_task(callback, *args, **kwargs)

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
        while not self._embedded.is_closed and self.__context.ok():
            self.spin_once()

    def spin_until_future_complete(
        self, future: Future[Any], timeout_sec: float | None = None
    ) -> None:
        """Run callbacks until a future is done or a timeout is over."""
        deadline = Deadline(timeout_sec)
        while not (future.done() or self._embedded.is_closed) and self.__context.ok():
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
        if chosen != self.__chosen:
            self.__chosen = chosen
            self.wake()
        work = self._embedded.next(Deadline(timeout_sec), condition)
        if isinstance(work, Task):
            return work, None, None
        if work is not None:
            task = Task(self._embedded.run, (work,), executor=self._embedded)
            return task, work[0], self.__node_of(work[0])
        if self._embedded.is_closed:
            raise ShutdownException
        if condition():
            raise ConditionReachedException
        raise TimeoutException

    def __node_of(self, source: Source) -> Any:
        for node in self.__nodes:
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
        self.__nodes.clear()
        self._embedded.close()
        return True

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.shutdown()
