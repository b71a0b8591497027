"""The command ``bdt compare``: the runs of several bags in one page."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bdt_analysis.commands.topic_options import add_topic_options, topic_selection
from bdt_msgs_py.commands import Command


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("bags", nargs="+", type=Path, metavar="BAG", help="rosbag2 folder or file")
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        default=Path("comparison.html"),
        help="page (default: comparison.html)",
    )
    add_topic_options(parser)
    parser.add_argument("--json", action="store_true", help="print the numbers of all runs")


def _compare(options: Namespace) -> int:
    # The list of commands needs neither numpy nor a plotting library.
    from bdt_analysis.compare import run_comparison  # noqa: PLC0415

    run_comparison(options.bags, options.output, topic_selection(options), as_json=options.json)
    return 0


COMMAND = Command(
    summary="overlay the runs of several bags in one page",
    description="Analyze several bags and set them side by side; needs no ROS.",
    add_arguments=_add_arguments,
    run=_compare,
)
