"""The command ``bdt bench``: cores and transport, measured."""

import json
from argparse import ArgumentParser, Namespace

from bdt_msgs_py.commands import Command


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("names", nargs="*", metavar="NAME", help="benchmarks (default: all)")
    parser.add_argument("--json", action="store_true", help="print the results as JSON")


def _bench(options: Namespace) -> int:
    # The list of commands needs neither numba nor python-control.
    from rich.console import Console  # noqa: PLC0415

    from bdt_study.benchmarks.bench import run_benchmarks  # noqa: PLC0415
    from bdt_study.benchmarks.bench_table import bench_table  # noqa: PLC0415

    measured = run_benchmarks(options.names)
    if options.json:
        print(json.dumps(measured, indent=2))
    else:
        Console().print(bench_table(measured["results"]))
    return 0


COMMAND = Command(
    summary="measure cores and transport beside a peer and a floor",
    description="Medians of one run on this machine, with ratios to a reference.",
    add_arguments=_add_arguments,
    run=_bench,
)
