"""Futures, and tasks that an executor runs."""

from __future__ import annotations

import inspect
import sys
import threading
import warnings
import weakref
from collections.abc import Callable, Coroutine, Generator
from typing import TYPE_CHECKING, Any, Generic, TypeVar

if TYPE_CHECKING:
    from rclpy.executors import Executor

__all__ = ["Future", "Task"]

T = TypeVar("T")


class Future(Generic[T]):
    """A result that is not there yet; a coroutine can await it.

    Parameters
    ----------
    executor : Executor, optional
        Runs the done callbacks. Without one they run where the result is set.
    """

    def __init__(self, *, executor: Executor | None = None) -> None:
        self._done = False
        self._cancelled = False
        self._result: T | None = None
        self._exception: BaseException | None = None
        self._exception_fetched = False
        self._callbacks: list[Callable[[Future[T]], Any]] = []
        self._lock = threading.Lock()
        self._executor: Callable[[], Executor | None] = _no_executor
        self._set_executor(executor)

    if not TYPE_CHECKING:

        def __class_getitem__(cls, _item: Any) -> None:
            # Generic for type checkers only: with rclpy 7.1 the expression fails at run time.
            raise TypeError(f"type '{cls.__name__}' is not subscriptable")

    def __del__(self) -> None:
        if self._exception is not None and not self._exception_fetched:
            print(
                f"The following exception was never retrieved: {self._exception}", file=sys.stderr
            )

    def __await__(self) -> Generator[Future[T], None, T | None]:
        while not self._done:
            yield self
        return self.result()

    def cancel(self) -> None:
        """Give the result up, unless it is there. Done callbacks are called."""
        with self._lock:
            if not self._done:
                self._cancelled = True
        self._schedule_done_callbacks()

    def cancelled(self) -> bool:
        """Tell whether the future was cancelled."""
        return self._cancelled

    def done(self) -> bool:
        """Tell whether there is a result or an exception."""
        return self._done

    def result(self) -> T | None:
        """Result; None if there is none yet. Raises the exception if there is one."""
        if self._exception is not None:
            self._exception_fetched = True
            raise self._exception
        return self._result

    def exception(self) -> BaseException | None:
        """Exception; None if there is none."""
        self._exception_fetched = True
        return self._exception

    def set_result(self, result: T) -> None:
        """Set the result."""
        with self._lock:
            self._result = result
            self._done = True
            self._cancelled = False
        self._schedule_done_callbacks()

    def set_exception(self, exception: BaseException) -> None:
        """Set an exception in place of a result."""
        with self._lock:
            self._exception = exception
            self._exception_fetched = False
            self._done = True
            self._cancelled = False
        self._schedule_done_callbacks()

    def _schedule_done_callbacks(self) -> None:
        with self._lock:
            executor = self._executor()
            callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            if executor is not None:
                executor.create_task(callback, self)
                continue
            try:
                callback(self)
            except Exception as error:  # noqa: BLE001 - the other callbacks must run, too
                warnings.warn(f"Unhandled exception in done callback: {error}", stacklevel=2)

    def _set_executor(self, executor: Executor | None) -> None:
        with self._lock:
            self._executor = _no_executor if executor is None else weakref.ref(executor)

    def add_done_callback(self, callback: Callable[[Future[T]], Any]) -> None:
        """Have a function called with this future when it is done; at once if it is."""
        with self._lock:
            if not self._done:
                self._callbacks.append(callback)
                return
            executor = self._executor()
        if executor is not None:
            executor.create_task(callback, self)
        else:
            callback(self)


def _no_executor() -> None:
    return None


if TYPE_CHECKING:
    _AnyFuture = Future[Any]
else:
    _AnyFuture = Future


class Task(_AnyFuture):
    """A function or coroutine that an executor runs; the future of its result.

    Parameters
    ----------
    handler : function, coroutine function or coroutine
    args, kwargs
        Arguments of `handler`.
    executor : Executor, optional
        Runs the task and its done callbacks.
    """

    def __init__(
        self,
        handler: Callable[..., Any] | Coroutine[Any, Any, Any],
        args: tuple[Any, ...] | list[Any] | None = None,
        kwargs: dict[str, Any] | None = None,
        executor: Executor | None = None,
    ) -> None:
        super().__init__(executor=executor)
        self._args = args or ()
        self._kwargs = kwargs or {}
        if inspect.iscoroutinefunction(handler):
            handler = handler(*self._args, **self._kwargs)
        self._handler: Any = handler
        self._executing = False
        self._task_lock = threading.Lock()
        #: What the coroutine awaits: it goes on when this is done.
        self._awaited: Future[Any] | None = None

    def __call__(self) -> None:
        """Run the function, or the coroutine to its next ``await``."""
        if self._done or not self._task_lock.acquire(blocking=False):
            return
        try:
            if self._done:
                return
            self._executing = True
            if inspect.iscoroutine(self._handler):
                yielded = self._handler.send(None)
                self._awaited = yielded if isinstance(yielded, Future) else None
            else:
                self._finish(self._handler(*self._args, **self._kwargs))
        except StopIteration as stop:
            self._finish(stop.value)
        except Exception as error:  # noqa: BLE001 - it is the result
            self._release()
            self.set_exception(error)
        finally:
            self._executing = False
            self._task_lock.release()

    def _finish(self, result: Any) -> None:
        self._release()
        self.set_result(result)

    def _release(self) -> None:
        self._handler = None
        self._args = ()
        self._kwargs = {}
        self._awaited = None

    def executing(self) -> bool:
        """Tell whether the task runs at this moment."""
        return self._executing
