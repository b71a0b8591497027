"""What has come out so far while a sweep runs."""

import numpy as np

from bdt_study.sweep.run_batch import BatchResult

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
