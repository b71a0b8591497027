"""Options of ``bdt evaluate``, apart from what it imports."""

import argparse
from pathlib import Path
from typing import Any

RUNS = 10
"""Runs of each case and estimator unless more are asked for."""


def add_evaluate_command(commands: Any) -> None:
    """Add ``evaluate`` to the commands of ``bdt``."""
    parser = commands.add_parser(
        "evaluate",
        help="compare estimators on data like a laboratory's",
        description="Run random scenarios in closed loop with each estimator and state errors, "
        "coverage of the stated uncertainty, limit cycles, bias and processor time.",
    )
    parser.add_argument(
        "--estimator",
        action="append",
        metavar="KIND",
        help="inverse_filter, output_error or module:name; may be repeated (default: both)",
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
    parser.add_argument("--figure", type=Path, metavar="FILE", help="picture of the errors")
    parser.add_argument("--json", action="store_true", help="print the table as JSON")
    parser.set_defaults(command=_evaluate)


def _evaluate(options: argparse.Namespace) -> int:
    # The other commands start without numba.
    from bdt_bringup.evaluation.command import evaluate  # noqa: PLC0415

    return evaluate(options)
