"""Progress of a run on the terminal: one line that is written anew.

It goes to standard error, so that ``--json`` stays clean. What is no terminal gets the last line.
"""

import math
import sys
from types import TracebackType
from typing import Protocol, Self

from bdt_bringup.loop_state import LoopState

_ERASE_LINE = "\r\x1b[K"
_BAR_WIDTH = 24


class ObservedLoop(Protocol):
    """What is known of a loop while it runs; :class:`bdt_bringup.monitor.MonitorNode` hears it.

    Attributes
    ----------
    simulated_time : float
        Latest simulated time [s].
    gap : float or None
        Latest estimate of the gap [rad].
    dead_zone : float or None
        Dead-zone tolerance in force [m].
    """

    simulated_time: float
    gap: float | None
    dead_zone: float | None

    @property
    def state(self) -> LoopState:
        """State of the loop, as its nodes say it."""

    def real_time_factor(self) -> float | None:
        """Return simulated seconds per second of wall time; None before the loop has begun."""


class ProgressDisplay:
    """A bar in simulated time with the state of the loop beside it.

    Parameters
    ----------
    title : str
        Name of the run.
    duration : float
        Simulated time of the whole run [s].
    """

    def __init__(self, title: str, duration: float) -> None:
        self._title = title
        self._duration = duration
        self._line = ""
        self._rewrites = sys.stderr.isatty()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        print("" if self._rewrites else self._line, file=sys.stderr)

    def show(self, loop: ObservedLoop) -> None:
        """Show the loop as it is now."""
        self._line = progress_line(self._title, self._duration, loop)
        if self._rewrites:
            print(f"{_ERASE_LINE}{self._line}", end="", file=sys.stderr, flush=True)


def progress_line(title: str, duration: float, loop: ObservedLoop) -> str:
    """Return title, bar, simulated time, real-time factor, gap estimate, dead zone as a line.

    A state of the loop that is not ok stands at its end.

    Parameters
    ----------
    title : str
        Name of the run.
    duration : float
        Simulated time of the whole run [s].
    loop : ObservedLoop
        The loop as it is now.
    """
    time = min(loop.simulated_time, duration)
    done = round(_BAR_WIDTH * time / duration)
    factor = loop.real_time_factor()
    parts = [f"{title} [{'#' * done}{'.' * (_BAR_WIDTH - done)}]", f"t = {time:6.1f} s"]
    if factor is not None:
        parts.append(f"{factor:.1f} x real time")
    if loop.gap is not None:
        parts.append(f"gap {math.degrees(loop.gap):.2f} deg")
    if loop.dead_zone is not None:
        parts.append(f"dead zone {loop.dead_zone * 1e6:.1f} um")
    state = loop.state
    if loop.simulated_time > 0.0 and state.node:
        parts.append(str(state))
    return "  ".join(parts)
