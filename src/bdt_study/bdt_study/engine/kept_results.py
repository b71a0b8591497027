"""Jobs whose results are kept as they come, until all are done or somebody wants an end."""

from collections.abc import Callable, Iterator
from pathlib import Path

from bdt_msgs_py.command_errors import LoopError
from bdt_msgs_py.stop_signals import StopSignals
from bdt_study.engine.job import Engine, Job, Result
from bdt_study.engine.job_progress import JobProgress


def keep_results(
    engine: Engine,
    jobs: Iterator[Job[Result]],
    keep: Callable[[int, Result], None],
    progress: JobProgress,
    folder: Path,
) -> None:
    """Work on jobs and keep what they give.

    Ctrl-C lets those in work be finished and begins no others; another one does not wait.

    Parameters
    ----------
    engine : Engine
        What works.
    jobs : iterator of Job
        The jobs.
    keep : callable
        Writes what a job with some number gave.
    progress : JobProgress
        What tells of it.
    folder : Path
        Where it is written.

    Raises
    ------
    BadInputError
        If a job raises it.
    LoopError
        If workers are lost or nothing can be written any more.
    """

    def until_requested(signals: StopSignals) -> Iterator[Job[Result]]:
        for job in jobs:
            if signals.requested:
                return
            yield job

    def keep_or_tell(number: int, result: Result) -> None:
        try:
            keep(number, result)
        except OSError as error:
            raise LoopError(f"{folder}: cannot be written: {error.strerror or error}") from error

    with progress, StopSignals(progress.end) as signals:
        try:
            for number, result in engine.results(until_requested(signals)):
                keep_or_tell(number, result)
        except LoopError as error:
            raise LoopError(f"{error}; what is there is whole: go on with --resume") from error
