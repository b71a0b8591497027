"""Running what a work loop hands out: functions, coroutines and tasks."""

from collections.abc import Coroutine
from types import CoroutineType
from typing import Any

from embedded_ros.futures import Task
from embedded_ros.work_loop import Job, Source, WorkLoop

__all__ = ["TaskRunningLoop"]


class TaskRunningLoop(WorkLoop):
    """A work loop that runs what it hands out."""

    def run(self, work: Job | Task) -> None:
        """Run work; what it raises comes out of here."""
        if isinstance(work, Task):
            self._advance(work)
            return
        source, function, arguments = work
        try:
            result = function(*arguments)
        except BaseException:
            self.finish(source)
            raise
        if result.__class__ is CoroutineType:
            self._advance(Task(self._then_finish(result, source), executor=self))
        else:
            self.finish(source)

    async def _then_finish(self, coroutine: Coroutine[Any, Any, Any], source: Source) -> Any:
        try:
            return await coroutine
        finally:
            self.finish(source)

    def _advance(self, task: Task) -> None:
        task()
        if task.done():
            error = task.exception()
            if error is not None:
                raise error
        elif task._awaits is not None:
            # By way of the queue: whoever settles the future must not run the coroutine.
            task._awaits.add_done_callback(lambda _: self.put(task))
        elif not task.cancelled():
            self.put_aside(task)
