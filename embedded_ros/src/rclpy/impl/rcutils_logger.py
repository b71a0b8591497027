"""Loggers."""

from __future__ import annotations

import sys
from types import FrameType
from typing import Any

from embedded_ros import log_output
from rclpy.clock import Clock
from rclpy.impl.logging_severity import LoggingSeverity

__all__ = ["RcutilsLogger"]

# A call may use several filters; they are asked in this order until one says no.
_FILTERS = {
    "throttle": ("throttle_duration_sec", "throttle_time_source_type"),
    "skip_first": ("skip_first",),
    "once": ("once",),
}
_PARAMETERS = [name for names in _FILTERS.values() for name in names]
_INTERNAL = (__name__, "rclpy.logging")


class _CallState:
    """What a logging call site with its filters remembers."""

    def __init__(self, severity: LoggingSeverity, name: str, options: dict[str, Any]) -> None:
        self.severity = severity
        self.name = name
        self.options = options
        self.filters = _filters_of(options)
        self._count = 0
        self._last_logged = 0
        if "throttle" in self.filters:
            if options.get("throttle_duration_sec") is None:
                raise TypeError(
                    'required parameter "throttle_duration_sec" not specified '
                    'but is required for the the logging filter "throttle"'
                )
            self._clock = options.get("throttle_time_source_type") or Clock()
            if not isinstance(self._clock, Clock):
                raise ValueError(
                    f'Received throttle_time_source_type of "{self._clock}" is not a clock instance'
                )

    def check(self, severity: LoggingSeverity, name: str, options: dict[str, Any]) -> None:
        """Reject a change between calls from one place."""
        if severity != self.severity:
            raise ValueError("Logger severity cannot be changed between calls.")
        if name != self.name:
            raise ValueError("Logger name cannot be changed between calls.")
        if _filters_of(options) != self.filters:
            raise ValueError("Requested logging filters cannot be changed between calls.")
        if options != self.options:
            raise ValueError("Logging filter parameters cannot be changed between calls.")

    def should_log(self) -> bool:
        """Ask the filters."""
        if "throttle" in self.filters:
            now = self._clock.now().nanoseconds
            if now < self._last_logged + self.options["throttle_duration_sec"] * 1e9:
                return False
            self._last_logged = now
        self._count += 1
        if "skip_first" in self.filters and self._count == 1:
            return False
        first = 2 if "skip_first" in self.filters else 1
        return "once" not in self.filters or self._count == first


def _filters_of(options: dict[str, Any]) -> list[str]:
    return [
        filter_name
        for filter_name, names in _FILTERS.items()
        if any(options.get(name) for name in names)
    ]


class RcutilsLogger:
    """A logger of a name; its level is its own or that of the nearest ancestor with one."""

    def __init__(self, name: str = "") -> None:
        self.name = name
        self._states: dict[tuple[str, int, int], _CallState] = {}

    def get_child(self, name: str) -> RcutilsLogger:
        """Make the logger ``<this name>.<name>``."""
        if not name:
            raise ValueError("Child logger name must not be empty.")
        return RcutilsLogger(f"{self.name}.{name}" if self.name else name)

    def set_level(self, level: LoggingSeverity | int) -> None:
        """Set the lowest severity that is logged."""
        log_output.set_level(self.name, LoggingSeverity(level))

    def get_effective_level(self) -> LoggingSeverity:
        """Lowest severity that is logged."""
        return LoggingSeverity(log_output.effective_level(self.name))

    def is_enabled_for(self, severity: LoggingSeverity | int) -> bool:
        """Tell whether messages of a severity are logged."""
        return LoggingSeverity(severity) >= log_output.effective_level(self.name)

    def log(self, message: str, severity: LoggingSeverity | int, **kwargs: Any) -> bool:
        """Log a message.

        Parameters
        ----------
        message : str
        severity : LoggingSeverity
        name : str, optional
            Name to log under.
        throttle_duration_sec : float, optional
            Log at most once in this time from this place.
        throttle_time_source_type : Clock, optional
            Clock for the throttle; system time by default.
        skip_first : bool, optional
            Leave out the first message from this place.
        once : bool, optional
            Log the first message from this place only.

        Returns
        -------
        bool
            Whether the message was logged.
        """
        severity = LoggingSeverity(severity)
        if severity < log_output.effective_level(self.name):
            return False
        name = kwargs.pop("name", self.name)
        for option in kwargs:
            if option not in _PARAMETERS:
                raise TypeError(
                    f'parameter "{option}" is not one of the recognized logging options '
                    f'"{_PARAMETERS}"'
                )
        frame = _caller()
        place = (frame.f_code.co_filename, frame.f_lineno, frame.f_lasti)
        state = self._states.get(place)
        if state is None:
            state = self._states[place] = _CallState(severity, name, dict(kwargs))
        else:
            state.check(severity, name, kwargs)
        if not state.should_log():
            return False
        code = frame.f_code
        log_output.output(
            log_output.Record(
                severity, name, str(message), code.co_filename, code.co_name, frame.f_lineno
            )
        )
        return True

    def debug(self, message: str, **kwargs: Any) -> bool:
        """Log with severity DEBUG; see :meth:`log`."""
        return self.log(message, LoggingSeverity.DEBUG, **kwargs)

    def info(self, message: str, **kwargs: Any) -> bool:
        """Log with severity INFO; see :meth:`log`."""
        return self.log(message, LoggingSeverity.INFO, **kwargs)

    def warning(self, message: str, **kwargs: Any) -> bool:
        """Log with severity WARN; see :meth:`log`."""
        return self.log(message, LoggingSeverity.WARN, **kwargs)

    def warn(self, message: str, **kwargs: Any) -> bool:
        """Log with severity WARN; see :meth:`log`."""
        return self.log(message, LoggingSeverity.WARN, **kwargs)

    def error(self, message: str, **kwargs: Any) -> bool:
        """Log with severity ERROR; see :meth:`log`."""
        return self.log(message, LoggingSeverity.ERROR, **kwargs)

    def fatal(self, message: str, **kwargs: Any) -> bool:
        """Log with severity FATAL; see :meth:`log`."""
        return self.log(message, LoggingSeverity.FATAL, **kwargs)


def _caller() -> FrameType:
    """Frame of the code that logs: the first one outside of the loggers."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__") in _INTERNAL:
        frame = frame.f_back
    return frame
