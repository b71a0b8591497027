"""Errors that end a command with one line and exit code 1."""


class CommandError(Exception):
    """What the user is told."""
