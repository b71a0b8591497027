"""Ctrl-C and SIGTERM as a request that is answered between two callbacks.

A KeyboardInterrupt in the middle of a callback could tear a message or a C library's state.
"""

import signal
from types import FrameType, TracebackType
from typing import Any, Self

NUMBERS = (signal.SIGINT, signal.SIGTERM)


class StopSignals:
    """Holds signals back while it is entered; use it in the main thread.

    Attributes
    ----------
    requested : bool
        True once a signal has come.
    """

    def __init__(self) -> None:
        self.requested = False
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
