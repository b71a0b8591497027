"""Ctrl-C and SIGTERM as requests to end, which tear nothing that is being done."""

import atexit
import signal
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, Self

NUMBERS = (signal.SIGINT, signal.SIGTERM)


class StopSignals:
    """Holds signals back while it is entered; use it in the main thread.

    The request is answered between two callbacks: a KeyboardInterrupt in the middle of one could
    tear a message or a C library's state.

    Parameters
    ----------
    on_request : callable, optional
        Called when a signal comes, in the main thread between any two steps of it.

    Attributes
    ----------
    requested : bool
        True once a signal has come.
    """

    def __init__(self, on_request: Callable[[], None] | None = None) -> None:
        self.requested = False
        self._on_request = on_request
        self._previous: list[Any] = []

    def __enter__(self) -> Self:
        self._previous = [signal.signal(number, self._request) for number in NUMBERS]
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        for number, handler in zip(NUMBERS, self._previous, strict=True):
            signal.signal(number, handler)

    def check(self) -> None:
        """Raise KeyboardInterrupt if a signal has come."""
        if self.requested:
            raise KeyboardInterrupt

    def _request(self, _number: int, _frame: FrameType | None) -> None:
        self.requested = True
        if self._on_request is not None:
            self._on_request()


class InterruptOfWork:
    """Has Ctrl-C interrupt a process while it works, and not while it ends; for the main thread.

    From its construction on SIGINT raises KeyboardInterrupt as in any Python program, but once at
    most and never after :meth:`work_is_over`: a signal asks for no more than an end, and that must
    be whole. This lasts until the process is gone. Where SIGINT has another meaning already, it
    keeps that.
    """

    def __init__(self) -> None:
        self._is_over = False
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, self._interrupt)
            # Before it unloads the modules, Python has the process killed by what it handled.
            atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)

    def work_is_over(self) -> None:
        """Let the process end undisturbed: the work is done."""
        self._is_over = True
        # Python remembers an interrupt that came out of the last text it executed, handled or
        # not, and would end a module's process by the signal. Numba executes texts.
        exec("")  # noqa: S102

    def _interrupt(self, _number: int, _frame: FrameType | None) -> None:
        if not self._is_over:
            self._is_over = True
            raise KeyboardInterrupt
