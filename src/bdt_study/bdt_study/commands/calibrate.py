"""The command ``bdt calibrate``: constants of a machine from a minute of its telemetry."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bdt_analysis.commands.topic_options import add_topic_options
from bdt_msgs_py.commands import Command

SECONDS = 60.0
"""Telemetry that is looked at unless less is asked for [s]."""


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "bag", type=Path, metavar="BAG", help="rosbag2 folder or file; bdt record makes one"
    )
    parser.add_argument(
        "--config",
        type=Path,
        metavar="FILE",
        help="parameter file with the start values, of the twin or else of the plant "
        "(default: what the bag tells of its twin, else table 1)",
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        help="parameter file for all nodes with the machine that was found, e.g. calibrated.yaml",
    )
    parser.add_argument("--report", type=Path, metavar="DIR", help="folder for report.html")
    parser.add_argument(
        "--seconds",
        type=float,
        metavar="S",
        default=SECONDS,
        help=f"longest telemetry that is looked at (default: {SECONDS:g})",
    )
    parser.add_argument(
        "--known",
        action="append",
        default=[],
        metavar="NAME",
        help="a constant that u and q3 cannot tell and whose start value is right, for example "
        "structure.mass (repeatable)",
    )
    add_topic_options(parser)
    parser.add_argument(
        "--run",
        type=int,
        metavar="N",
        help="which run, from 1, of a bag whose recorder went on while the loop was started again",
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def _calibrate(options: Namespace) -> int:
    # The list of commands needs neither numba nor a plotting library.
    from bdt_study.calibration.run_calibration import run_calibration  # noqa: PLC0415

    return run_calibration(options)


COMMAND = Command(
    summary="find the constants of a machine in a bag",
    description="Find gap, motor, friction, structure, delay and offset of a machine in at most a "
    "minute of its telemetry, beginning with values that may be off by a factor of two.",
    add_arguments=_add_arguments,
    run=_calibrate,
)
