"""Real-time execution of a node's process: priority, locked memory, garbage collected in the slack.

It stands beside :mod:`bdt_msgs_py.node_main`, on the floor that driver and controller share. Linux
alone has it; what a machine refuses is said, and the process goes on as an ordinary one.
"""

import contextlib
import ctypes
import gc
import os
import resource
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from bdt_msgs_py.quantities import quantity, validate

_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
_CAP_IPC_LOCK = 14
"""Number of the capability to lock memory without a limit."""


@dataclass(frozen=True)
class RealTimeSettings:
    """How the process of a node competes with others; everything is off by default."""

    priority: int = quantity(
        0,
        "",
        "priority of the process among real-time ones (SCHED_FIFO), above all ordinary processes; "
        "0 leaves it an ordinary one",
        minimum=0,
        maximum=99,
    )
    lock_memory: bool = quantity(
        False, "", "whether the memory of the process is kept from being swapped out (mlockall)"
    )
    collect_in_slack: bool = quantity(
        False,
        "",
        "whether Python collects garbage after the work of a control period, and never within it",
    )

    def __post_init__(self) -> None:
        validate(self)


class RealTimeProcess:
    """The process of a node that does its work in periods.

    Parameters
    ----------
    settings : RealTimeSettings
        What is asked for.
    warn : callable
        Gets a line for each thing that the machine refuses.

    Attributes
    ----------
    refusals : list of str
        These lines.
    """

    def __init__(self, settings: RealTimeSettings, warn: Callable[[str], object]) -> None:
        self._collects = settings.collect_in_slack
        self.refusals = enter_real_time(settings)
        for refusal in self.refusals:
            warn(refusal)

    def use_slack(self) -> None:
        """Do what must not happen within a period; call it when the work of one is done."""
        if self._collects:
            collect_due_garbage()


def enter_real_time(settings: RealTimeSettings) -> list[str]:
    """Give this process what the settings ask for, as far as the machine grants it.

    Call it when the process is set up: the objects there are then count as permanent, and are not
    looked at in later collections.

    Parameters
    ----------
    settings : RealTimeSettings
        What is asked for.

    Returns
    -------
    list of str
        What was refused: a line each, with the parameter, the reason and what to do.
    """
    refusals: list[str] = []
    if settings.priority:
        refusals += _take_priority(settings.priority)
    if settings.lock_memory:
        refusals += _lock_memory()
    if settings.collect_in_slack:
        gc.collect()
        gc.freeze()
        gc.disable()
    return refusals


def collect_due_garbage() -> None:
    """Collect the oldest generation of garbage that is due; for the slack of a control period.

    It is due when Python itself would collect it, had it not been told to leave that to us.
    """
    counts, thresholds = gc.get_count(), gc.get_threshold()
    for generation in (2, 1, 0):
        if counts[generation] > thresholds[generation] > 0:
            gc.collect(generation)
            return


def _take_priority(priority: int) -> Iterator[str]:
    """Schedule all threads there are first in, first out; those to come inherit it."""
    if sys.platform != "linux":
        yield f"real_time.priority = {priority}: is there on Linux alone"
        return
    parameters = os.sched_param(priority)
    try:
        for thread in Path("/proc/self/task").iterdir():
            with contextlib.suppress(ProcessLookupError):  # it has ended meanwhile
                os.sched_setscheduler(int(thread.name), os.SCHED_FIFO, parameters)
    except PermissionError:
        allowed = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
        yield (
            f"real_time.priority = {priority}: refused, this user may have {allowed}; allow it "
            "with CAP_SYS_NICE or a limit for rtprio"
        )


def _lock_memory() -> Iterator[str]:
    if sys.platform != "linux":
        yield "real_time.lock_memory: is there on Linux alone"
        return
    if not _may_lock_all_memory():
        # Within a limit it would be granted at first, and later every allocation could fail.
        limit = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]
        yield (
            f"real_time.lock_memory: refused, this user may lock {limit} bytes; allow it with "
            "CAP_IPC_LOCK or memlock unlimited"
        )
        return
    # On fault: what no thread ever touches of its stack needs no memory.
    flags = _MCL_CURRENT | _MCL_FUTURE | _MCL_ONFAULT
    if ctypes.CDLL(None, use_errno=True).mlockall(flags):
        yield f"real_time.lock_memory: refused, {os.strerror(ctypes.get_errno())}"


def _may_lock_all_memory() -> bool:
    if resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] == resource.RLIM_INFINITY:
        return True
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    effective = next(line for line in status.splitlines() if line.startswith("CapEff:"))
    return bool(int(effective.split()[1], 16) >> _CAP_IPC_LOCK & 1)
