"""How programs of this project end: errors of one line, and exit codes."""

import sys

FAILED = 1
"""The loop, a node or a claim failed."""

BAD_INPUT = 2
"""The user's input cannot be used; one line says why."""

INTERRUPTED = 130
"""Ended by Ctrl-C, as shells have it."""


class BadInputError(ValueError):
    """Something that a user gave is missing or not allowed; the text is one line.

    What a file or a message brings along may hold any character: those that would leave the line
    or move the cursor are replaced.
    """

    def __init__(self, reason: str) -> None:
        super().__init__(printable(reason))


class LoopError(RuntimeError):
    """The control loop cannot go on, for example because another node is gone."""


def printable(text: str) -> str:
    """Return a text in one line, with ``?`` for what a terminal does not print."""
    line = " ".join(text.split())
    return "".join(character if character.isprintable() else "?" for character in line)


def complain(reason: object, code: int) -> int:
    """Print an error in one line on standard error and return the exit code."""
    print(f"error: {' '.join(str(reason).split())}", file=sys.stderr)
    return code
