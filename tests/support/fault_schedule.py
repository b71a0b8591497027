"""Schedules of faults: made from a seed, written as a line, read back, and made shorter."""

import random
from collections.abc import Callable
from typing import NamedTuple

NODES = ("controller", "twin", "recorder")
WRITERS = ("twin", "recorder")
"""Nodes that write files."""
CHANNELS = ("measurement", "command", "telemetry", "clock")
MESSAGE_FAULTS = ("loss", "duplicate", "delay", "reorder", "nan", "step")
KINDS = ("kill", "stop", "hostile", "full", *MESSAGE_FAULTS)
"""What goes wrong: with nodes, the last of it a full disk, and with messages."""

FIRST, LAST = 0.5, 3.0
"""Simulated time between which faults begin [s]."""
LONGEST = 1.0
"""Time for which a fault lasts at most [s]: of a stopped node and a full disk by the wall clock."""


class Fault(NamedTuple):
    """Something that goes wrong.

    Attributes
    ----------
    time : float
        Simulated time at which it begins [s].
    kind : str
        One of ``KINDS``.
    target : str
        Node, or channel of messages.
    duration : float
        How long it lasts [s].
    share : float
        Share of the messages that it hits.
    """

    time: float
    kind: str
    target: str
    duration: float = 0.0
    share: float = 1.0

    @property
    def end(self) -> float:
        """Simulated time at which it is over [s]."""
        return self.time + self.duration

    def __str__(self) -> str:
        """Return the fault as words."""
        return f"{self.time:g} {self.kind} {self.target} {self.duration:g} {self.share:g}"


Schedule = tuple[Fault, ...]


def schedule_of(seed: int) -> Schedule:
    """Return the schedule of a seed: one to four faults."""
    draw = random.Random(seed)  # noqa: S311
    faults = []
    for _ in range(draw.randint(1, 4)):
        kind = draw.choice(KINDS)
        channels = {"step": ("clock",), "nan": CHANNELS[:3]}.get(kind, CHANNELS)
        nodes = WRITERS if kind == "full" else NODES
        target = draw.choice(channels if kind in MESSAGE_FAULTS else nodes)
        lasts = kind in ("stop", "full", *MESSAGE_FAULTS)
        faults.append(
            Fault(
                round(draw.uniform(FIRST, LAST), 2),
                kind,
                target,
                round(draw.uniform(0.1, LONGEST), 2) if lasts else 0.0,
                round(draw.uniform(0.05, 0.6), 2) if kind in MESSAGE_FAULTS else 1.0,
            )
        )
    return tuple(sorted(faults))


def line_of(schedule: Schedule) -> str:
    """Return a schedule as a line."""
    return "; ".join(map(str, schedule))


def schedule_from(line: str) -> Schedule:
    """Return the schedule of a line.

    Raises
    ------
    ValueError
        If it is none.
    """
    faults = []
    for words in filter(None, map(str.split, line.split(";"))):
        time, kind, target, duration, share = words
        if kind not in KINDS or target not in (*NODES, *CHANNELS):
            raise ValueError(f"{' '.join(words)}: must be TIME KIND TARGET DURATION SHARE")
        faults.append(Fault(float(time), kind, target, float(duration), float(share)))
    return tuple(faults)


def shrunk(schedule: Schedule, fails: Callable[[Schedule], bool]) -> Schedule:
    """Return a schedule that fails as well, and does not without any one of its faults."""
    number = 0
    while number < len(schedule):
        shorter = schedule[:number] + schedule[number + 1 :]
        if shorter and fails(shorter):
            schedule = shorter
        else:
            number += 1
    return schedule
