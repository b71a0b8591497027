"""What a check is, and how it ends."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

from bdt_driver.hardware_check.drive_stand import DriveStand


class CheckFailedError(Exception):
    """The drive does not keep a point of the contract; the text says what was found."""


class CheckSkippedError(Exception):
    """A check cannot say anything about this drive; the text says why."""


class Outcome(StrEnum):
    """How a check ended."""

    OK = "ok"
    FAILED = "failed"
    SKIPPED = "skipped"


@dataclass(frozen=True)
class Check:
    """A point of the contract.

    Attributes
    ----------
    name : str
        Name, in small letters.
    run : callable
        Gets the stand and returns what it found, in a few words. It raises
        :class:`CheckFailedError` or :class:`CheckSkippedError`.
    reason : str
        Why the point matters.
    advice : str
        What to do when the check fails.
    needs : tuple of str
        Names of checks without which this one says nothing; they come before it.
    moves : bool
        Whether the machine may move.
    """

    name: str
    run: Callable[[DriveStand], str]
    reason: str
    advice: str
    needs: tuple[str, ...] = ("reads",)
    moves: bool = False


class CheckResult(NamedTuple):
    """A check and how it ended.

    Attributes
    ----------
    check : Check
        The check.
    outcome : Outcome
        How it ended.
    text : str
        What was found, or why it was skipped.
    """

    check: Check
    outcome: Outcome
    text: str


def require(condition: bool, text: str) -> None:
    """Raise that a check has failed, unless a condition holds.

    Raises
    ------
    CheckFailedError
        With the text.
    """
    if not condition:
        raise CheckFailedError(text)
