"""An engine without workers: for little work, which is done before a process has started."""

from collections.abc import Iterator

from bdt_study.engine.job import Engine, Job, Result


class InThisProcess(Engine):
    """Does one job after the other, where it is asked for."""

    def end(self) -> None:
        """Do nothing: there is nothing to let go of."""

    def results(self, jobs: Iterator[Job[Result]]) -> Iterator[tuple[int, Result]]:
        """Iterate over results; see :meth:`bdt_study.engine.job.Engine.results`."""
        for job in jobs:
            yield job.number, job.run()
