"""Signals held back while a C library calls Python functions.

Python runs the handler of a signal at the beginning of the next Python function, and that may be
one that the library has called. What a handler raises there, ``KeyboardInterrupt`` for one, is lost
in a library that makes an error of its own of it.
"""

import signal
import threading
from types import FrameType, TracebackType
from typing import Any, Final, Self

__all__ = ["HeldSignals"]

_NUMBERS: Final = (signal.SIGINT, signal.SIGTERM)


class HeldSignals:
    """Has handlers run after the block rather than in it; does nothing outside the main thread."""

    def __init__(self) -> None:
        self._handlers: dict[int, Any] = {}
        self._came: list[int] = []

    def __enter__(self) -> Self:
        if threading.current_thread() is not threading.main_thread():
            return self
        try:
            for number in _NUMBERS:
                handler = signal.getsignal(number)
                if callable(handler):
                    self._handlers[number] = handler
                    signal.signal(number, self._hold)
        except BaseException:
            self._restore()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._restore()
        for number in self._came:
            self._handlers[number](number, None)

    def _restore(self) -> None:
        for number, handler in self._handlers.items():
            signal.signal(number, handler)

    def _hold(self, number: int, _frame: FrameType | None) -> None:
        self._came.append(number)
