"""What distributions require, one through the other, as the metadata of the installed ones say."""

import re
from collections.abc import Collection, Iterable
from importlib.metadata import Distribution, distribution

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

_LOCKED = re.compile(r"^([\w.-]+)==")


def required_distributions(
    names: Iterable[str], *, without: Collection[str] = ()
) -> dict[str, Distribution]:
    """Return distributions with all that they require.

    Parameters
    ----------
    names : iterable of str
        Distributions, with extras in brackets.
    without : collection of str
        Names that are left out, with what they alone require.

    Returns
    -------
    dict
        Installed distributions by their normal name.

    Raises
    ------
    importlib.metadata.PackageNotFoundError
        If one of them is not installed.
    """
    found: dict[str, Distribution] = {}
    asked: set[tuple[str, str]] = set()
    waiting = [Requirement(name) for name in names]
    while waiting:
        requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        if name in without:
            continue
        found.setdefault(name, distribution(name))
        for extra in {"", *requirement.extras} - {
            extra for asked_of, extra in asked if asked_of == name
        }:
            asked.add((name, extra))
            waiting += [
                needed
                for needed in map(Requirement, found[name].requires or ())
                if needed.marker is None or needed.marker.evaluate({"extra": extra})
            ]
    return found


def locked_part(lock: str, names: Collection[str]) -> str:
    """Return the entries of a lock file that belong to some distributions.

    Parameters
    ----------
    lock : str
        Content of a requirements file as pip-compile writes it, with hashes.
    names : collection of str
        Normal names; what is not locked is left out.
    """
    lines = []
    wanted = False
    for line in lock.splitlines(keepends=True):
        if entry := _LOCKED.match(line):
            wanted = canonicalize_name(entry[1]) in names
        if wanted:
            lines.append(line)
    return "".join(lines)
