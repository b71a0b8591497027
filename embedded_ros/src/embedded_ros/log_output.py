"""Where log messages go: standard error and ``/rosout``; and the levels that let them pass."""

import contextlib
import os
import re
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

__all__ = [
    "Record",
    "add_sink",
    "clear_levels",
    "effective_level",
    "level",
    "output",
    "remove_sink",
    "set_level",
    "set_stderr_enabled",
]

_NAMES = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}
_COLORS = {10: "32", 20: "0", 30: "33", 40: "31", 50: "31"}
_DEFAULT_LEVEL = 20
_DEFAULT_FORMAT = "[{severity}] [{time}] [{name}]: {message}"

_lock = threading.Lock()
_levels: dict[str, int] = {}
_sinks: dict[str, list[Callable[["Record", int], None]]] = {}
_stderr_enabled = True


@dataclass(frozen=True)
class Record:
    """A log message and where it comes from."""

    severity: int
    name: str
    message: str
    file: str
    function: str
    line: int


def set_level(name: str, severity: int) -> None:
    """Set the level of a logger; 0 unsets it, the empty name is the default for all."""
    with _lock:
        if severity:
            _levels[name] = severity
        else:
            _levels.pop(name, None)


def level(name: str) -> int:
    """Level that was set for a logger, or 0."""
    return _levels.get(name, 0)


def effective_level(name: str) -> int:
    """Level of a logger, of its nearest ancestor that has one, or the default."""
    while name:
        if name in _levels:
            return _levels[name]
        name = name.rpartition(".")[0]
    return _levels.get("", _DEFAULT_LEVEL)


def clear_levels() -> None:
    """Forget all levels."""
    with _lock:
        _levels.clear()


def set_stderr_enabled(enabled: bool) -> None:
    """Switch the output to standard error."""
    global _stderr_enabled
    _stderr_enabled = enabled


def add_sink(name: str, sink: Callable[[Record, int], None]) -> None:
    """Have the messages of a logger and its children passed on, with their time in nanoseconds."""
    with _lock:
        _sinks.setdefault(name, []).append(sink)


def remove_sink(name: str, sink: Callable[[Record, int], None]) -> None:
    """Undo :func:`add_sink`."""
    with _lock:
        sinks = _sinks.get(name, [])
        if sink in sinks:
            sinks.remove(sink)
        if not sinks:
            _sinks.pop(name, None)


def output(record: Record) -> None:
    """Write a message, whatever its level."""
    now = time.time_ns()
    if _stderr_enabled:
        line = _formatted(record, now)
        if _is_colored():
            line = f"\033[{_COLORS.get(record.severity, '0')}m{line}\033[0m"
        # A disk that is full is nothing that a node should end of: rcutils does not look, either.
        with contextlib.suppress(OSError):
            # One write a line: other processes may write to the same terminal.
            sys.stderr.write(f"{line}\n")
            sys.stderr.flush()
    name = record.name
    while name:
        for sink in tuple(_sinks.get(name, ())):
            sink(record, now)
        name = name.rpartition(".")[0]


def _formatted(record: Record, now: int) -> str:
    values = {
        "severity": _NAMES.get(record.severity, "UNSET"),
        "time": f"{now // 10**9}.{now % 10**9:09d}",
        "time_as_nanoseconds": str(now),
        "name": record.name,
        "message": record.message,
        "function_name": record.function,
        "file_name": record.file,
        "line_number": str(record.line),
    }
    template = os.environ.get("RCUTILS_CONSOLE_OUTPUT_FORMAT") or _DEFAULT_FORMAT
    return re.sub(r"\{(\w+)\}", lambda found: values.get(found[1], found[0]), template)


def _is_colored() -> bool:
    choice = os.environ.get("RCUTILS_COLORIZED_OUTPUT", "")
    return choice == "1" or (choice != "0" and sys.stderr.isatty())
