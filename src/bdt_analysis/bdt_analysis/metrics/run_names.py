"""Short names of runs, from the paths of their bags."""

from collections.abc import Sequence
from pathlib import Path

from bdt_msgs_py.output_files import real_path

USUAL_BAG_NAME = "bag"
"""Name that `bdt run` gives to every bag: it tells nothing, the folder around it does."""


def run_names(bags: Sequence[Path]) -> list[str]:
    """Return the shortest ends of the paths that differ, without ``bag`` as the last part.

    A bag that is given twice gets a number.
    """
    paths = [real_path(bag) for bag in bags]
    parts = [
        (path.parent if path.name == USUAL_BAG_NAME else path).parts or (str(path),)
        for path in paths
    ]
    longest = max(len(part) for part in parts)
    length = next(
        (n for n in range(1, longest) if len({part[-n:] for part in parts}) == len(set(parts))),
        longest,
    )
    names = ["/".join(part[-length:]) for part in parts]
    return [
        f"{name} ({names[: k + 1].count(name)})" if names.count(name) > 1 else name
        for k, name in enumerate(names)
    ]
