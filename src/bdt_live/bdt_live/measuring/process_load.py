"""What processes run and cost, from /proc: words, memory and time of the processor."""

import os
import re
from contextlib import suppress
from pathlib import Path
from statistics import median

ENDED = (FileNotFoundError, ProcessLookupError)
"""What reading of a process raises that has ended meanwhile, as parts of a browser do."""


def tree_of(process: int) -> list[int]:
    """Return a process and all that it has started, directly and through others."""
    found = [process]
    for each in found:
        for task in Path(f"/proc/{each}/task").glob("*/children"):
            with suppress(*ENDED):
                found += [int(child) for child in task.read_text().split()]
    return found


def words_of(process: int) -> list[str]:
    """Return the command line of a process, word by word; none if it has ended."""
    with suppress(*ENDED):
        # A kernel thread and one that is about to end have an empty line.
        line = Path(f"/proc/{process}/cmdline").read_bytes().decode(errors="replace")
        return line.rstrip("\0").split("\0") if line else []
    return []


def memory_of(processes: list[int]) -> int:
    """Return the memory of some processes [byte]; what several share is counted once (PSS)."""
    kilobytes = 0
    for process in processes:
        with suppress(*ENDED):
            text = Path(f"/proc/{process}/smaps_rollup").read_text()
            kilobytes += sum(map(int, re.findall(r"^Pss:\s+(\d+) kB", text, re.MULTILINE)))
    return 1024 * kilobytes


def processor_time_of(process: int) -> float:
    """Return user and system time of a process [s]."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def growth(samples: list[int]) -> float:
    """Return by how much samples grow from their second to their last quarter, as a share.

    Compared are medians; the first quarter is for what fills up to its limit.
    """
    quarter = max(len(samples) // 4, 1)
    return median(samples[-quarter:]) / median(samples[quarter : 2 * quarter] or samples) - 1.0
