"""The engine that a user asks for by ``--workers`` and ``--scheduler``."""

from bdt_msgs_py.command_errors import BadInputError
from bdt_study.engine.job import Engine
from bdt_study.engine.local_workers import LocalWorkers
from bdt_study.engine.optional_packages import CLUSTERS, check_imports

MOST_WORKERS = 1024


def chosen_engine(workers: int | None, scheduler: str | None = None) -> Engine:
    """Return an engine, which has to be entered.

    Parameters
    ----------
    workers : int, optional
        Processes on this computer; None for one for each core.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers take the place of these.

    Raises
    ------
    BadInputError
        If the number makes no sense, both are given, Dask is missing, or no scheduler answers.
    """
    check_workers(workers, scheduler)
    if scheduler is None:
        return LocalWorkers(workers)
    check_imports("--scheduler", CLUSTERS)
    # Nobody needs Dask on a single computer.
    from bdt_study.engine.dask_cluster import DaskCluster  # noqa: PLC0415

    return DaskCluster(scheduler)


def check_workers(workers: int | None, scheduler: str | None = None) -> None:
    """Refuse what :func:`chosen_engine` refuses, as far as nobody else has to be asked."""
    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise BadInputError(f"--workers {workers}: must be 1 to {MOST_WORKERS}")
    if workers is not None and scheduler is not None:
        raise BadInputError("--workers: is for this computer, a --scheduler has workers of its own")
