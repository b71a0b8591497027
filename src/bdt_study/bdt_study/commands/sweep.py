"""The command ``bdt sweep``: many closed loops over parameters."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.commands import Command

NEEDED = ("pyarrow",)
"""Python packages without which there is no sweep, and that nothing else here has a use for."""


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("study", type=Path, metavar="STUDY.yaml", help="which loops, and what of")
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder of the data set (default: sweeps/NAME OF THE STUDY)",
    )
    parser.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="processes on this computer (default: one for each core)",
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on with what is in the folder already"
    )
    parser.add_argument(
        "--dry-run",
        action="store_true",
        help="check the study, say how many runs it has, how long it takes and how large it gets",
    )
    parser.add_argument("--json", action="store_true", help="print the outcome as JSON")


def _sweep(options: Namespace) -> int:
    try:
        # The list of commands needs neither numba nor pyarrow.
        from bdt_study.sweep.run_sweep import sweep  # noqa: PLC0415
    except ModuleNotFoundError as error:
        if error.name not in NEEDED:
            raise
        raise BadInputError(f"bdt sweep: needs the Python package {error.name}") from error
    return sweep(options)


COMMAND = Command(
    summary="run a study: many loops over parameters, on all cores",
    description="Run closed loops over grids, ranges and samples of parameters on all cores, into "
    "a Parquet data set that can be read at any moment and resumed after any end.",
    add_arguments=_add_arguments,
    run=_sweep,
)
