"""The command ``bdt reproduce``: every simulation of the paper again."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bdt_msgs_py.command_errors import LoopError
from bdt_msgs_py.commands import Command
from bdt_study.commands.engine_options import add_workers


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        default=Path("reproduction"),
        help="folder for index.html, figures and claims.json (default: reproduction)",
    )
    add_workers(parser)
    parser.add_argument("--json", action="store_true", help="print claims.json")


def _reproduce(options: Namespace) -> int:
    # The list of commands needs neither numba nor a plotting library.
    from bdt_study.engine.chosen_engine import chosen_engine  # noqa: PLC0415
    from bdt_study.reproduction.reproduce import run_reproduction  # noqa: PLC0415

    with chosen_engine(options.workers) as engine:
        failed = run_reproduction(engine, options.output, as_json=options.json)
    if failed:
        raise LoopError(f"{failed} claims do not hold")
    return 0


COMMAND = Command(
    summary="redo the paper: figures, claims, sweeps",
    description="Redo the simulations of the paper offline, draw figures 2, 3, 4, 6 and 7, and "
    "set its claims beside what was measured. Exit code 1 if one does not hold.",
    add_arguments=_add_arguments,
    run=_reproduce,
)
