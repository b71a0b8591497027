"""How far the work is, how fast it goes and how long it takes, in a line on standard error."""

from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeRemainingColumn,
)


class JobProgress:
    """A line on standard error.

    Parameters
    ----------
    name : str
        What is worked on.
    total : int
        Runs that there are.
    done : int
        Runs that were there before.
    """

    def __init__(self, name: str, total: int, done: int = 0) -> None:
        self._is_ending = False
        self._display = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            TextColumn("{task.fields[found]}"),
            console=Console(stderr=True),
            transient=True,
            speed_estimate_period=60.0,
        )
        self._task = self._display.add_task(name, total=total, completed=done, rate="", found="")

    def __enter__(self) -> Self:
        self._display.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._display.stop()

    def add(self, runs: int, found: str = "") -> None:
        """Show that some more runs are done, and what was found so far."""
        self._display.advance(self._task, runs)
        speed = self._display.tasks[0].speed
        rate = f"{speed:.3g} runs/s" if speed else ""
        self._display.update(self._task, rate=rate, found=found)

    def end(self) -> None:
        """Show that no more jobs begin.

        Raises
        ------
        KeyboardInterrupt
            If that has been shown before: somebody does not want to wait for those in work.
        """
        if self._is_ending:
            raise KeyboardInterrupt
        self._is_ending = True
        self._display.update(
            self._task, description="finishes what is in work, not after another Ctrl-C"
        )
