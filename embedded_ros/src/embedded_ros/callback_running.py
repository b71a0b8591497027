"""Running callbacks: the part of :class:`rclpy.executors.Executor` that calls user code."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from types import CoroutineType
from typing import TYPE_CHECKING, Any, cast

from embedded_ros.readiness import Entity, Readiness, Work
from rclpy.client import Client
from rclpy.service import Service
from rclpy.task import Task

if TYPE_CHECKING:
    from rclpy.executors import Executor

__all__ = ["CallbackRunning"]


class CallbackRunning(Readiness):
    """Takes what is ready and runs its callbacks, functions and coroutines."""

    def create_task(
        self, callback: Callable[..., Any] | Coroutine[Any, Any, Any], *args: Any, **kwargs: Any
    ) -> Task:
        """Have a function or coroutine run, with arguments.

        Returns
        -------
        Task
            Future of the result.
        """
        task = Task(callback, args, kwargs, executor=cast("Executor", self))
        self._tasks.append(task)
        self._guard.set()
        return task

    def _claim(self, entity: Entity) -> Any:
        """Take what an entity has, if its group lets its callback run now."""
        group = entity.callback_group
        if group is not None and not group.beginning_execution(entity):
            # Marked first: the group may be released at this very moment.
            self._has_blocked = True
            self._entities_changed = True
            return None
        try:
            taken = entity._take()
        except BaseException:
            self._release(entity)
            raise
        if taken is None:
            self._release(entity)
        return taken

    def _release(self, entity: Entity) -> None:
        if entity.callback_group is not None:
            entity.callback_group.ending_execution(entity)
        if self._has_blocked:
            self.wake()

    def _run(self, work: Work) -> None:
        """Run a callback; its exception comes out of here."""
        if isinstance(work, Task):
            self._step(work)
            return
        entity, taken = work
        is_suspended = False
        try:
            result = self._call(entity, taken)
            if result.__class__ is CoroutineType:
                task = Task(
                    _and_then(result, lambda: self._release(entity)),
                    executor=cast("Executor", self),
                )
                is_suspended = True
                self._step(task)
        finally:
            if not is_suspended:
                self._release(entity)

    def _call(self, entity: Entity, taken: Any) -> Any:
        if isinstance(entity, Service):
            header, request = taken
            response = entity.callback(request, entity.srv_type.Response())
            if response.__class__ is CoroutineType:
                return _answer(entity, header, response)
            entity.send_response(response, header)
            return None
        if isinstance(taken, tuple):
            callback, arguments = taken
            if isinstance(entity, Client):
                callback.__self__._set_executor(self)
            return callback(*arguments)
        return taken()

    def _step(self, task: Task) -> None:
        task()
        if task.done():
            error = task.exception()
            if error is not None:
                raise error
        elif task._awaited is not None:
            # Through this executor's queue: whoever sets the result must not run the coroutine.
            task._awaited.add_done_callback(lambda _: self._resume(task))
        elif not task.cancelled():
            self._yielded.append(task)

    def _resume(self, task: Task) -> None:
        self._tasks.append(task)
        self._guard.set()


async def _and_then(coroutine: Coroutine[Any, Any, Any], finish: Callable[[], None]) -> Any:
    try:
        return await coroutine
    finally:
        finish()


async def _answer(service: Service, header: Any, response: Coroutine[Any, Any, Any]) -> None:
    service.send_response(await response, header)
