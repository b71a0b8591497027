"""The command ``bdt analyze``: the report of one bag."""

import json
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from bdt_analysis.commands.estimator_options import add_estimator_options
from bdt_analysis.commands.topic_options import add_topic_options, topic_selection
from bdt_msgs_py.commands import Command

if TYPE_CHECKING:
    from bdt_analysis.metrics.summary import Summary


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("bag", type=Path, metavar="BAG", help="rosbag2 folder or file")
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder for the report (default: BAG_report, or BAG_run_N_report)",
    )
    add_topic_options(parser)
    parser.add_argument(
        "--run",
        type=int,
        metavar="N",
        help="which run, from 1, of a bag whose recorder went on while the loop was started again",
    )
    parser.add_argument(
        "--export",
        metavar="FORMATS",
        help="also write figures (png, svg) and signals (csv, parquet); separated by commas",
    )
    add_estimator_options(parser)
    parser.add_argument("--json", action="store_true", help="print summary.json")


def _analyze(options: Namespace) -> int:
    # The list of commands needs neither numpy nor a plotting library.
    from bdt_analysis.analyze import analyze  # noqa: PLC0415
    from bdt_analysis.export import checked_formats  # noqa: PLC0415
    from bdt_analysis.re_estimation.estimator_setup import given_settings  # noqa: PLC0415

    run = "" if options.run is None else f"_run_{options.run}"
    output = options.output or options.bag.parent / f"{options.bag.name}{run}_report"
    selection = topic_selection(options)
    formats = checked_formats(options.export) if options.export is not None else ()
    settings = given_settings(options.estimator, options.set)
    summary = analyze(options.bag, output, selection, formats, settings, options.run)
    if options.json:
        print(json.dumps(summary.to_dictionary(), indent=2))
    else:
        _print_summary(summary, output)
    return 0


def _print_summary(summary: "Summary", output: Path) -> None:
    from rich.console import Console  # noqa: PLC0415

    from bdt_analysis.analyze import REPORT_FILE  # noqa: PLC0415
    from bdt_analysis.pages.re_estimation_report import re_estimation_lines  # noqa: PLC0415
    from bdt_analysis.pages.report import verdict  # noqa: PLC0415
    from bdt_analysis.pages.step_table import step_table  # noqa: PLC0415

    console = Console()
    console.print(step_table(summary))
    result = verdict(summary)
    console.print(f"{result.headline}: {result.details}", soft_wrap=True, highlight=False)
    if summary.re_estimation is not None:
        for line in re_estimation_lines(summary.re_estimation):
            console.print(line, soft_wrap=True, highlight=False, markup=False)
    if summary.missing:
        console.print(f"note: {'; '.join(summary.missing)}", soft_wrap=True, highlight=False)
    console.print(f"report: {output / REPORT_FILE}", soft_wrap=True, highlight=False)


COMMAND = Command(
    summary="write report.html and summary.json for a bag",
    description="Analyze a bag; needs no ROS and leaves the bag as it is.",
    add_arguments=_add_arguments,
    run=_analyze,
)
