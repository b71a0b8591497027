"""Options of the commands that run many loops, and what they say where a package is missing."""

from argparse import ArgumentParser
from collections.abc import Iterator
from contextlib import contextmanager

from bdt_msgs_py.command_errors import BadInputError

OPTIONAL = ("pyarrow", "SALib", "distributed")
"""Python packages of the extra `sweep`: nobody needs them without data sets and clusters."""


def add_workers(parser: ArgumentParser) -> None:
    """Add ``--workers``."""
    parser.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="processes on this computer (default: one for each core)",
    )


def add_scheduler(parser: ArgumentParser) -> None:
    """Add ``--scheduler``."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="of a Dask scheduler, e.g. tcp://10.0.0.1:8786, whose workers do the work",
    )


def add_resume(parser: ArgumentParser) -> None:
    """Add ``--resume``."""
    parser.add_argument(
        "--resume", action="store_true", help="go on with what is in the folder already"
    )


@contextmanager
def missing_packages_told(command: str) -> Iterator[None]:
    """Have a package that is missing said in one line.

    Parameters
    ----------
    command : str
        What needs it.

    Raises
    ------
    BadInputError
        If one of `OPTIONAL` cannot be imported.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name not in OPTIONAL:
            raise
        raise BadInputError(f"{command}: needs the Python package {error.name}") from error
