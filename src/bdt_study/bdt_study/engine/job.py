"""A job, and an engine: what works on jobs."""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from types import TracebackType
from typing import Protocol, Self, TypeVar

AHEAD = 2
"""Jobs for each worker that are given out: one in work, and the next one at hand."""

MOST_DEATHS = 5
"""Deaths of workers with no job done in between after which it is no accident."""

Result = TypeVar("Result")
Result_co = TypeVar("Result_co", covariant=True)


class Job(Protocol[Result_co]):
    """Work that a process can do that knows nothing but the job; both can be pickled."""

    @property
    def number(self) -> int:
        """What tells it from all jobs that an engine has at the same time."""

    @property
    def name(self) -> str:
        """What it is, in a few words."""

    def run(self) -> Result_co:
        """Do the work."""


class Engine(ABC):
    """Works on jobs from when it is entered to when it is left; see :meth:`results`."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.end()

    @abstractmethod
    def end(self) -> None:
        """Let go of processes and connections at once."""

    @abstractmethod
    def results(self, jobs: Iterator[Job[Result]]) -> Iterator[tuple[int, Result]]:
        """Iterate over numbers of jobs and their results as they come, in any order.

        Jobs are asked for as there is room for them; when there are no more, those in work are
        finished.

        Raises
        ------
        BadInputError
            If a job raises it.
        LoopError
            If workers end again and again, or are out of reach.
        """
