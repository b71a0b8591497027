"""The command ``bdt design``: the PID design behind the default gains."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bdt_msgs_py.commands import Command


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        default=Path("design.png"),
        help="picture (default: design.png)",
    )
    parser.add_argument("--json", action="store_true", help="print gains and margins as JSON")


def _design(options: Namespace) -> int:
    # The list of commands needs neither python-control nor a plotting library.
    from bdt_study.design.run_design import run_design  # noqa: PLC0415

    run_design(options.output, as_json=options.json)
    return 0


COMMAND = Command(
    summary="design the PID and draw Bode, Nyquist and step response",
    description="Repeat the design behind the default gains: first gain crossover at "
    "10 rad/s, phase margins of 10 degrees or more, smallest maximum sensitivity.",
    add_arguments=_add_arguments,
    run=_design,
)
