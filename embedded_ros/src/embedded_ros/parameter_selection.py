"""Which names a request for a list of parameters means."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

__all__ = ["SEPARATOR", "parents", "select"]

SEPARATOR: Final = "."


def select(names: Iterable[str], prefixes: Sequence[str], depth: int) -> list[str]:
    """Names that are one of the prefixes or stand below one.

    Parameters
    ----------
    names : iterable of str
    prefixes : sequence of str
        Without the separator behind them; none of them: all names.
    depth : int
        Number of levels below a prefix, or of all if there is none, that are looked at; 0: all.
    """
    return [
        name
        for name in names
        if any(_level(name, prefix, depth) for prefix in prefixes)
        or (not prefixes and _is_near(name, depth))
    ]


def _level(name: str, prefix: str, depth: int) -> bool:
    head, rest = name[: len(prefix)], name[len(prefix) :]
    if head != prefix:
        return False
    return not rest or (rest[0] == SEPARATOR and _is_near(rest[1:], depth))


def _is_near(rest: str, depth: int) -> bool:
    return depth == 0 or rest.count(SEPARATOR) < depth


def parents(names: Iterable[str]) -> list[str]:
    """What stands before the last separators, each once, in the order of the names."""
    return list(dict.fromkeys(name.rpartition(SEPARATOR)[0] for name in names if SEPARATOR in name))
