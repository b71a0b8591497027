"""How a command ends before its work is done."""

import difflib
from collections.abc import Iterable

__all__ = ["CommandError", "Terminated", "did_you_mean", "one_line"]


class CommandError(RuntimeError):
    """What the user is told, in one line; the exit code is 1."""

    def __init__(self, text: object) -> None:
        super().__init__(one_line(text))


class Terminated(Exception):
    """SIGTERM came."""


def one_line(text: object) -> str:
    """Text without its line ends and indentation."""
    return " ".join(str(text).split())


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """End of a complaint about a name that nobody knows: the nearest one that is known."""
    every = set(known)
    place, _, last = name.rpartition("/")
    # Names in one place are alike by that alone, so what is behind it counts.
    beside = {each.rpartition("/")[2]: each for each in every if each.rpartition("/")[0] == place}
    near = [beside[each] for each in difflib.get_close_matches(last, beside, 1, 0.7)]
    near += difflib.get_close_matches(name, every - set(beside.values()), 1, 0.8)
    return f"; did you mean '{near[0]}'?" if near else ""
