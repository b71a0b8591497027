"""The command ``bdt tune``: gains and dead zone for a mechanism that is known within ranges."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bdt_msgs_py.commands import Command
from bdt_study.commands.engine_options import add_workers

SCREENING = 100
"""Random loops by which candidates are chosen, unless more are asked for."""
LOOPS = 1000
"""Random loops in which the chosen one is confirmed, unless fewer are asked for."""


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="parameter file with the mechanism, e.g. calibrated.yaml (default: table 1)",
    )
    parser.add_argument(
        "--calibration",
        type=Path,
        metavar="JSON",
        help="what bdt calibrate --json has printed, for how sure its constants are",
    )
    parser.add_argument(
        "--range",
        action="append",
        default=[],
        metavar="NAME=SHARE",
        help="largest deviation of back_emf, mass, stiffness or damping of either sign, e.g. "
        "damping=0.2 (repeatable; default: those of the case harsh, 0.05, 0.02, 0.02, 0.2)",
    )
    parser.add_argument(
        "--bandwidth",
        type=float,
        metavar="W",
        help="first gain crossover that is asked for [rad/s] (default: the paper's 10)",
    )
    parser.add_argument(
        "--phase-margin",
        type=float,
        metavar="DEG",
        help="smallest phase margin that is asked for [deg] (default: the paper's 10)",
    )
    parser.add_argument(
        "--screening",
        type=int,
        metavar="N",
        default=SCREENING,
        help=f"random loops for each candidate (default: {SCREENING})",
    )
    parser.add_argument(
        "--loops",
        type=int,
        metavar="N",
        default=LOOPS,
        help=f"random loops that confirm the recommendation (default: {LOOPS})",
    )
    parser.add_argument(
        "--seed", type=int, metavar="N", default=0, help="number of the first loop (default: 0)"
    )
    add_workers(parser)
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        help="parameter file with what is recommended, e.g. tuned.yaml",
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def _tune(options: Namespace) -> int:
    # The list of commands needs neither numba nor python-control.
    from bdt_study.tuning.run_tuning import run_tuning  # noqa: PLC0415

    return run_tuning(options)


COMMAND = Command(
    summary="design gains and dead zone for a mechanism within ranges",
    description="Design gains for the worst mechanism within ranges, judge them by python-control "
    "and in random closed loops with a growing gap, and recommend one with its evidence.",
    add_arguments=_add_arguments,
    run=_tune,
)
