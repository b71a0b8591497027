"""Results that are not there yet, and tasks that produce them."""

import functools
import inspect
import sys
import threading
import warnings
import weakref
from collections.abc import Callable, Coroutine, Generator
from contextlib import AbstractContextManager
from enum import Enum
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

__all__ = ["Future", "Task", "TaskRunner"]

T = TypeVar("T")


class TaskRunner(Protocol):
    """What runs functions later: an executor."""

    def create_task(self, callback: Callable[..., Any], *args: Any) -> Any:
        """Have a function called with arguments."""
        ...


class _Phase(Enum):
    """Where a future stands. One that is given up may still be settled."""

    OPEN = 0
    GIVEN_UP = 1
    SETTLED = 2


class Future(Generic[T]):
    """A result that is not there yet; a coroutine can await it.

    Parameters
    ----------
    executor : Executor, optional
        Runs the done callbacks. Without one they run where the result is set.
    """

    def __init__(self, *, executor: TaskRunner | None = None) -> None:
        self._phase = _Phase.OPEN
        self._value: T | None = None
        self._error: BaseException | None = None
        self._error_is_known = False
        self._gate = threading.Lock()
        self._followers: list[Callable[[Future[T]], Any]] = []
        # Whoever blocks until the future is settled; woken at once, whatever runs the followers.
        self._sleepers: list[Callable[[], None]] = []
        self._runner: weakref.ref[TaskRunner] | None = None
        self._run_followers_in(executor)

    if not TYPE_CHECKING:

        def __class_getitem__(cls, _item: Any) -> None:
            # Generic for type checkers only: with rclpy 7.1 the expression fails at run time.
            raise TypeError(f"type '{cls.__name__}' is not subscriptable")

    def __del__(self) -> None:
        if self._error is not None and not self._error_is_known:
            print(f"The following exception was never retrieved: {self._error}", file=sys.stderr)

    def __await__(self) -> Generator["Future[T]", None, T | None]:
        while self._phase is not _Phase.SETTLED:
            yield self
        return self.result()

    # ------------------------------------------------------------------ state

    def done(self) -> bool:
        """Tell whether there is a result or an exception."""
        return self._phase is _Phase.SETTLED

    def cancelled(self) -> bool:
        """Tell whether the future was cancelled."""
        return self._phase is _Phase.GIVEN_UP

    def result(self) -> T | None:
        """Result; None if there is none yet. Raises the exception if there is one."""
        error = self._error
        if error is None:
            return self._value
        self._error_is_known = True
        raise error

    def exception(self) -> BaseException | None:
        """Exception; None if there is none."""
        self._error_is_known = True
        return self._error

    def cancel(self) -> None:
        """Give the result up, unless it is there. Done callbacks are called."""
        self._enter(_Phase.GIVEN_UP)

    def set_result(self, result: T) -> None:
        """Set the result."""
        self._enter(_Phase.SETTLED, value=result)

    def set_exception(self, exception: BaseException) -> None:
        """Set an exception in place of a result."""
        self._enter(_Phase.SETTLED, error=exception)

    def _enter(
        self, phase: _Phase, *, value: T | None = None, error: BaseException | None = None
    ) -> None:
        with self._gate:
            if phase is _Phase.SETTLED or self._phase is _Phase.OPEN:
                self._phase = phase
            if error is not None:
                self._error, self._error_is_known = error, False
            elif phase is _Phase.SETTLED:
                self._value = value
            followers, self._followers = self._followers, []
            sleepers = tuple(self._sleepers)
        for wake in sleepers:
            wake()
        for follower in followers:
            try:
                self._tell(follower)
            except Exception as failure:  # noqa: BLE001 - the other callbacks must run, too
                warnings.warn(f"Unhandled exception in done callback: {failure}", stacklevel=3)

    # ------------------------------------------------------------------ who waits

    def add_done_callback(self, callback: Callable[["Future[T]"], Any]) -> None:
        """Have a function called with this future when it is done; at once if it is."""
        with self._gate:
            is_settled = self._phase is _Phase.SETTLED
            if not is_settled:
                self._followers.append(callback)
        if is_settled:
            self._tell(callback)

    def _tell(self, follower: Callable[["Future[T]"], Any]) -> None:
        runner = None if self._runner is None else self._runner()
        if runner is None:
            follower(self)
        else:
            runner.create_task(follower, self)

    def _run_followers_in(self, runner: TaskRunner | None) -> None:
        """Have done callbacks run as tasks, from now on."""
        self._runner = None if runner is None else weakref.ref(runner)

    def _waking(self, wake: Callable[[], None]) -> "_Waking":
        """Have `wake` called if the future is settled or given up meanwhile, by any thread."""
        return _Waking(self._gate, self._sleepers, wake)


class _Waking:
    """A sleeper of a future for the time of a ``with`` block.

    No generator: an executor that spins until a future is done enters one for each callback.
    """

    __slots__ = ("_gate", "_sleepers", "_wake")

    def __init__(
        self,
        gate: AbstractContextManager[Any],
        sleepers: list[Callable[[], None]],
        wake: Callable[[], None],
    ) -> None:
        self._gate = gate
        self._sleepers = sleepers
        self._wake = wake

    def __enter__(self) -> None:
        with self._gate:
            self._sleepers.append(self._wake)

    def __exit__(self, *_: object) -> None:
        with self._gate:
            self._sleepers.remove(self._wake)


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
        executor: TaskRunner | None = None,
    ) -> None:
        super().__init__(executor=executor)
        #: What the coroutine awaits: it goes on when this is done.
        self._awaits: Future[Any] | None = None
        self._turn = threading.Lock()
        self._advance: Callable[[], Any] | None
        self._is_coroutine = inspect.iscoroutine(handler) or inspect.iscoroutinefunction(handler)
        begin: Any = handler
        if inspect.iscoroutine(handler):
            self._advance = functools.partial(handler.send, None)
        elif self._is_coroutine:
            coroutine = begin(*(args or ()), **(kwargs or {}))
            self._advance = functools.partial(coroutine.send, None)
        else:
            self._advance = lambda: begin(*(args or ()), **(kwargs or {}))

    def __call__(self) -> None:
        """Run the function, or the coroutine to its next ``await``."""
        if not self._turn.acquire(blocking=False):
            return
        try:
            if self._advance is not None:
                self._go_on(self._advance)
        finally:
            self._turn.release()

    def _go_on(self, advance: Callable[[], Any]) -> None:
        try:
            came_out = advance()
        except Exception as outcome:  # noqa: BLE001 - it is the result
            if self._is_coroutine and isinstance(outcome, StopIteration):
                self._finish(value=outcome.value)
            else:
                self._finish(error=outcome)
        else:
            if self._is_coroutine:
                self._awaits = came_out if isinstance(came_out, Future) else None
            else:
                self._finish(value=came_out)

    def _finish(self, *, value: Any = None, error: BaseException | None = None) -> None:
        # The arguments need not live as long as whoever keeps the result.
        self._advance = self._awaits = None
        self._enter(_Phase.SETTLED, value=value, error=error)

    def executing(self) -> bool:
        """Tell whether the task runs at this moment."""
        return self._turn.locked()
