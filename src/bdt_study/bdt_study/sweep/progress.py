"""What is known while a sweep runs: how fast it goes, how long it takes, what came out so far."""

from types import TracebackType
from typing import Self

import numpy as np
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeRemainingColumn,
)

from bdt_study.sweep.run_batch import BatchResult
from bdt_study.sweep.study import Study

SHOWN = 2
"""Quantities whose first results the progress shows."""


class Tally:
    """Count and mean of each quantity of the runs that are done.

    Parameters
    ----------
    names : tuple of str
        Names of the quantities.
    """

    def __init__(self, names: tuple[str, ...]) -> None:
        self._names = names
        self._known = np.zeros(len(names), dtype=np.int64)
        self._sums = np.zeros(len(names))
        self._largest = np.full(len(names), -np.inf)
        self.runs = 0

    def add(self, result: BatchResult) -> None:
        """Count the runs of a batch."""
        values = result.values
        known = ~np.isnan(values)
        self.runs += len(values)
        self._known += known.sum(axis=0)
        self._sums += np.where(known, values, 0.0).sum(axis=0)
        self._largest = np.maximum(
            self._largest, np.where(known, values, -np.inf).max(axis=0, initial=-np.inf)
        )

    def summary(self) -> dict[str, dict[str, float | int | None]]:
        """Return for each quantity in how many runs it is known, its mean and its largest value."""
        return {
            name: {
                "known": int(known),
                "mean": float(total / known) if known else None,
                "largest": float(largest) if known else None,
            }
            for name, known, total, largest in zip(
                self._names, self._known, self._sums, self._largest, strict=True
            )
        }

    def line(self) -> str:
        """Return the means of the first quantities in a few words."""
        shown = list(self.summary().items())[:SHOWN]
        return ", ".join(
            f"{name} {told['mean']:.3g}" for name, told in shown if told["mean"] is not None
        )


class SweepProgress:
    """A line on standard error.

    Parameters
    ----------
    study : Study
        The study.
    done : int
        Runs that were there before.
    """

    def __init__(self, study: Study, done: int) -> None:
        self._tally = Tally(study.compute)
        self._is_ending = False
        self._display = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            TextColumn("{task.fields[first]}"),
            console=Console(stderr=True),
            transient=True,
            speed_estimate_period=60.0,
        )
        self._task = self._display.add_task(
            study.name, total=study.runs, completed=done, rate="", first=""
        )

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

    @property
    def tally(self) -> Tally:
        """What came out since the sweep was started."""
        return self._tally

    def add(self, result: BatchResult) -> None:
        """Show a batch that is done."""
        self._tally.add(result)
        self._display.advance(self._task, len(result.values))
        speed = self._display.tasks[0].speed
        rate = f"{speed:.3g} runs/s" if speed else ""
        self._display.update(self._task, rate=rate, first=self._tally.line())

    def end(self) -> None:
        """Show that no more batches begin.

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
