"""Loggers by name, and their levels."""

from embedded_ros import log_output
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.impl.rcutils_logger import RcutilsLogger

__all__ = [
    "LoggingSeverity",
    "RcutilsLogger",
    "clear_config",
    "get_logger",
    "get_logger_effective_level",
    "get_logger_level",
    "get_logging_severity_from_string",
    "set_logger_level",
]


def get_logger(name: str) -> RcutilsLogger:
    """Make the logger of a name."""
    if not name:
        raise ValueError("Logger name must not be empty.")
    return RcutilsLogger(name)


def clear_config() -> None:
    """Forget all logger levels."""
    log_output.clear_levels()


def set_logger_level(
    name: str,
    level: int | LoggingSeverity,
    detailed_error: bool = False,  # noqa: ARG001 - all errors are detailed here
) -> None:
    """Set the lowest severity that a logger and its children log."""
    log_output.set_level(name, LoggingSeverity(level))


def get_logger_effective_level(name: str) -> LoggingSeverity:
    """Lowest severity that a logger logs."""
    return LoggingSeverity(log_output.effective_level(name))


def get_logger_level(name: str) -> LoggingSeverity:
    """Level that was set for a logger; ``UNSET`` if none was."""
    return LoggingSeverity(log_output.level(name))


def get_logging_severity_from_string(log_severity: str) -> LoggingSeverity:
    """Severity of a name in any case."""
    try:
        return LoggingSeverity[log_severity.upper()]
    except KeyError:
        raise RuntimeError(f"failed to get log severity from {log_severity!r}") from None
