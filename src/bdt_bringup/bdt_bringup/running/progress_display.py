"""Progress of a run on the terminal; on standard error, so that --json stays clean."""

import math
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from bdt_bringup.running.monitor import MonitorNode


class ProgressDisplay:
    """A progress bar in simulated time with the state of the loop beside it.

    Parameters
    ----------
    title : str
        Name of the run.
    duration : float
        Simulated time of the whole run [s].
    """

    def __init__(self, title: str, duration: float) -> None:
        self._duration = duration
        self._progress = Progress(
            TextColumn("[bold]{task.description}"),
            BarColumn(),
            TextColumn("{task.fields[state]}"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
        )
        self._task = self._progress.add_task(title, total=duration, state="starting")

    def __enter__(self) -> Self:
        self._progress.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._progress.stop()

    def show(self, monitor: MonitorNode) -> None:
        """Show the latest that the monitor heard."""
        time = min(monitor.simulated_time, self._duration)
        self._progress.update(self._task, completed=time, state=state_line(monitor, time))


def state_line(monitor: MonitorNode, time: float) -> str:
    """Return simulated time, real-time factor, gap estimate and dead zone as one line."""
    factor = monitor.real_time_factor()
    parts = [f"t = {time:6.1f} s"]
    if factor is not None:
        parts.append(f"{factor:.1f} x real time")
    if monitor.gap is not None:
        parts.append(f"gap {math.degrees(monitor.gap):.2f} deg")
    if monitor.dead_zone is not None:
        parts.append(f"dead zone {monitor.dead_zone * 1e6:.1f} um")
    return "  ".join(parts)
