"""Warnings of the runtime itself, about what others do to it."""

import sys
import time
from typing import Final

from embedded_ros import log_output

__all__ = ["Complaints"]

_LOGGER: Final = "embedded_ros"
_WARN: Final = 30
_PATIENCE_S: Final = 1.0


class Complaints:
    """Warnings about one thing, at most one a second."""

    def __init__(self) -> None:
        self._last = float("-inf")

    def add(self, text: str) -> None:
        """Log a warning under the name of the runtime, unless the last one is too fresh."""
        now = time.monotonic()
        if now - self._last < _PATIENCE_S or log_output.effective_level(_LOGGER) > _WARN:
            return
        self._last = now
        frame = sys._getframe(1)
        code = frame.f_code
        log_output.output(
            log_output.Record(_WARN, _LOGGER, text, code.co_filename, code.co_name, frame.f_lineno)
        )
