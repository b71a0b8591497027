"""The command ``bdt bench``: cores and transport, measured."""

import json
from argparse import ArgumentParser, Namespace

from bdt_msgs_py.command_errors import FAILED, BadInputError, complain
from bdt_msgs_py.commands import Command
from bdt_study.benchmarks.result import BenchmarkResult, BenchmarkSize, missed_targets

SHORTEST, LONGEST = 1.0, 86400.0
"""Times for which a loop in real time is measured [s]."""


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("names", nargs="*", metavar="NAME", help="benchmarks (default: all)")
    parser.add_argument(
        "--duration",
        type=float,
        default=BenchmarkSize.real_time_duration,
        metavar="S",
        help="of each loop of real_time, of three browsers of live [s] (default: %(default)g)",
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="end with 1, and a line for each, if targets are missed, as live has them",
    )
    parser.add_argument("--json", action="store_true", help="print the results as JSON")


def _bench(options: Namespace) -> int:
    # The list of commands needs neither numba nor python-control.
    from rich.console import Console  # noqa: PLC0415

    from bdt_study.benchmarks.bench import run_benchmarks  # noqa: PLC0415
    from bdt_study.benchmarks.bench_table import bench_table  # noqa: PLC0415

    if not SHORTEST <= options.duration <= LONGEST:
        raise BadInputError(
            f"--duration {options.duration!r} s: must be {SHORTEST:g} to {LONGEST:g}"
        )
    size = BenchmarkSize(real_time_duration=options.duration)
    measured = run_benchmarks(options.names, size)
    if options.json:
        print(json.dumps(measured, indent=2))
    else:
        Console().print(bench_table(measured["results"]))
    if not options.check:
        return 0
    missed = missed_targets(BenchmarkResult(**result) for result in measured["results"])
    for line in missed:
        complain(line, FAILED)
    return FAILED if missed else 0


COMMAND = Command(
    summary="measure cores and transport beside a peer and a floor",
    description="Medians of one run on this machine, with ratios to a reference.",
    add_arguments=_add_arguments,
    run=_bench,
)
