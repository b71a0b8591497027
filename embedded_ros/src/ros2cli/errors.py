"""Errors that end a command with one line and exit code 1."""

__all__ = ["CommandError"]


class CommandError(RuntimeError):
    """What the user is told."""
