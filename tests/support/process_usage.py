"""What a process holds of memory, descriptors and threads, and whether that stays as it is."""

import time
from pathlib import Path
from typing import NamedTuple


class Usage(NamedTuple):
    """What a process holds at a moment.

    Attributes
    ----------
    time : float
        Wall time [s], of any origin.
    memory : int
        Memory that it has written to and shares with nobody [byte]. Clean pages of files do not
        count: they are private or shared as others who use the same libraries come and go.
    descriptors, threads : int
        Their number.
    """

    time: float
    memory: int
    descriptors: int
    threads: int


def usage_of(pid: int) -> Usage:
    """Return what a process holds now."""
    process = Path("/proc") / str(pid)
    rows = (row.split() for row in (process / "smaps_rollup").read_text().splitlines())
    private = sum(int(row[1]) for row in rows if row[0] in ("Private_Dirty:", "Swap:"))
    descriptors, threads = (len(list((process / name).iterdir())) for name in ("fd", "task"))
    return Usage(time.monotonic(), 1024 * private, descriptors, threads)


def growth(usages: list[Usage]) -> Usage:
    """Return by how much a process has grown from the first to the last quarter of its samples.

    Compared are the medians of the memory, and the largest numbers of the others: single samples
    differ, as messages and diagnostics come and go.
    """
    quarter = max(len(usages) // 4, 1)
    first, last = usages[:quarter], usages[-quarter:]
    return Usage(
        last[0].time - first[0].time,
        _median([one.memory for one in last]) - _median([one.memory for one in first]),
        max(one.descriptors for one in last) - max(one.descriptors for one in first),
        max(one.threads for one in last) - max(one.threads for one in first),
    )


def _median(numbers: list[int]) -> int:
    return sorted(numbers)[len(numbers) // 2]
