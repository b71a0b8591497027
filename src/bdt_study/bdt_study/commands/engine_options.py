"""Options of the commands that run many loops."""

from argparse import ArgumentParser


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
