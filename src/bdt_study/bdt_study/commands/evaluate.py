"""The command ``bdt evaluate``: estimators on random scenarios."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bdt_msgs_py.commands import Command
from bdt_study.commands.engine_options import add_resume, add_scheduler, add_workers

RUNS = 10
"""Runs of each case and estimator unless more are asked for."""


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--estimator",
        action="append",
        metavar="KIND",
        help="inverse_filter, output_error or module:name; may be repeated (default: both)",
    )
    parser.add_argument(
        "--decision",
        action="append",
        choices=("equation_9", "simulate"),
        help="how the twin decides on dead zone and gains; may be repeated "
        "(default: as each case has it)",
    )
    parser.add_argument(
        "--cases",
        nargs="+",
        metavar="CASE",
        help="clean, laboratory, harsh and more, which the table lists (default: all)",
    )
    parser.add_argument(
        "--runs", type=int, metavar="N", default=RUNS, help=f"runs of each (default: {RUNS})"
    )
    parser.add_argument(
        "--seed", type=int, metavar="N", default=0, help="number of the first scenario (default: 0)"
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder in which each finished run is kept, as Parquet",
    )
    add_resume(parser)
    add_workers(parser)
    add_scheduler(parser)
    parser.add_argument("--figure", type=Path, metavar="FILE", help="picture of the errors")
    parser.add_argument("--json", action="store_true", help="print the table as JSON")


def _evaluate(options: Namespace) -> int:
    # The list of commands needs neither numba nor a plotting library.
    from bdt_study.evaluation.evaluate import evaluate  # noqa: PLC0415

    return evaluate(options)


COMMAND = Command(
    summary="compare estimators on data like a laboratory's",
    description="Run random scenarios in closed loop with each estimator and state errors, "
    "coverage of the stated uncertainty, limit cycles, bias and processor time.",
    add_arguments=_add_arguments,
    run=_evaluate,
)
