"""The command ``bdt``: run the loop, analyze a bag, redo the paper, design, measure."""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from bdt_bringup.analysis.estimator_options import add_estimator_options
from bdt_bringup.analysis.topic_options import add_topic_options, topic_selection
from bdt_bringup.bag_writing.metadata_file import is_unfinished
from bdt_bringup.bags.bag_error import BagError
from bdt_bringup.bags.topic_selection import TopicSelection
from bdt_bringup.benchmarks.bench_table import bench_table
from bdt_bringup.evaluation.options import add_evaluate_command
from bdt_bringup.recovery.command import add_recover_command
from bdt_bringup.running.configuration import BadInputError, load_configuration
from bdt_bringup.running.record_command import add_record_command
from bdt_bringup.running.recording_options import add_recording_options, recorder_settings
from bdt_bringup.running.run_plan import plan_run
from bdt_msgs_py.exit_codes import BAD_INPUT, FAILED, LoopError

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command; the console script ``bdt``."""
    sys.exit(run_command(arguments))


def run_command(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Command line without the program's name; None for ``sys.argv``.

    Returns
    -------
    int
        0 for success, 1 when the loop failed, 2 for bad input, 130 after Ctrl-C.
    """
    options = _parser().parse_args(arguments)
    try:
        return int(options.command(options))
    except (BadInputError, BagError) as error:
        return _complain(str(error), BAD_INPUT)
    except LoopError as error:
        return _complain(str(error), FAILED)
    except KeyboardInterrupt:
        return _complain("interrupted", INTERRUPTED)


def _run(options: argparse.Namespace) -> int:
    # The loop starts without waiting for the plotting libraries, and a bag needs no rclpy.
    from bdt_bringup.running.run import run_loop  # noqa: PLC0415

    plan = plan_run(
        load_configuration(options.config),
        mode=options.mode,
        duration=options.duration,
        processes=options.processes,
        output=options.output,
        record=options.bag,
        recorder=recorder_settings(options),
    )
    try:
        factor = run_loop(plan)
    except KeyboardInterrupt:
        kept = f"; what was recorded is in {plan.bag}" if plan.record else ""
        return _complain(f"interrupted{kept}", INTERRUPTED)
    if plan.record and is_unfinished(plan.bag):
        raise LoopError(
            f"{plan.bag} has no end, see {plan.output / 'log'}: "
            "`bdt recover` makes a whole one of it"
        )
    if plan.record:
        _report(plan.bag, plan.output, as_json=options.json)
    elif options.json:
        print(json.dumps({"duration": plan.duration, "real_time_factor": factor}, indent=2))
    return 0


def _analyze(options: argparse.Namespace) -> int:
    from bdt_bringup.analysis.estimator_setup import given_settings  # noqa: PLC0415
    from bdt_bringup.analysis.export import checked_formats  # noqa: PLC0415

    run = "" if options.run is None else f"_run_{options.run}"
    beside = options.bag.parent / f"{options.bag.name}{run}_report"
    selection = topic_selection(options)
    formats = checked_formats(options.export) if options.export is not None else ()
    settings = given_settings(options.estimator, options.set)
    output = options.output or beside
    _report(options.bag, output, selection, formats, settings, options.run, as_json=options.json)
    return 0


def _compare(options: argparse.Namespace) -> int:
    from bdt_bringup.analysis.compare_command import run_comparison  # noqa: PLC0415

    run_comparison(options.bags, options.output, topic_selection(options), as_json=options.json)
    return 0


def _design(options: argparse.Namespace) -> int:
    from bdt_bringup.design.command import run_design  # noqa: PLC0415

    run_design(options.output, as_json=options.json)
    return 0


def _reproduce(options: argparse.Namespace) -> int:
    from bdt_bringup.reproduction.command import run_reproduction  # noqa: PLC0415

    failed = run_reproduction(options.output, as_json=options.json)
    if failed:
        return _complain(f"{failed} claims do not hold", FAILED)
    return 0


def _bench(options: argparse.Namespace) -> int:
    from bdt_bringup.benchmarks.bench import BENCHMARKS, run_benchmarks  # noqa: PLC0415

    for name in options.names:
        if name not in BENCHMARKS:
            raise BadInputError(f"benchmark {name!r}: must be one of {', '.join(BENCHMARKS)}")
    measured = run_benchmarks(options.names)
    if options.json:
        print(json.dumps(measured, indent=2))
    else:
        Console().print(bench_table(measured["results"]))
    return 0


def _report(
    bag: Path,
    output: Path,
    selection: TopicSelection | None = None,
    formats: Sequence[str] = (),
    settings: Mapping[str, Any] | None = None,
    run: int | None = None,
    *,
    as_json: bool,
) -> None:
    from bdt_bringup.analysis.analyze import analyze  # noqa: PLC0415
    from bdt_bringup.analysis.re_estimation_report import re_estimation_lines  # noqa: PLC0415
    from bdt_bringup.analysis.report import verdict  # noqa: PLC0415
    from bdt_bringup.analysis.step_table import step_table  # noqa: PLC0415

    summary = analyze(bag, output, selection, formats, settings, run)
    if as_json:
        print(json.dumps(summary.to_dictionary(), indent=2))
        return
    console = Console()
    console.print(step_table(summary))
    result = verdict(summary)
    console.print(f"{result.headline}: {result.details}", soft_wrap=True, highlight=False)
    if summary.re_estimation is not None:
        for line in re_estimation_lines(summary.re_estimation):
            console.print(line, soft_wrap=True, highlight=False, markup=False)
    if summary.missing:
        console.print(f"note: {'; '.join(summary.missing)}", soft_wrap=True, highlight=False)
    console.print(f"report: {output / 'report.html'}", soft_wrap=True, highlight=False)


def _complain(reason: str, code: int) -> int:
    print(f"error: {reason}", file=sys.stderr)
    return code


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="bdt",
        description="Position control of a flexible structure whose lead screw wears out: "
        "plant, dead-zone controller and digital twin as ROS 2 nodes.",
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    run = commands.add_parser(
        "run",
        help="start the nodes, record a bag, write a report",
        description="Start plant, controller, twin and recorder, and analyze what they recorded.",
    )
    run.add_argument("--config", type=Path, metavar="FILE", help="ROS parameter file (config/)")
    run.add_argument(
        "--mode",
        choices=("lockstep", "realtime"),
        help="simulated time as fast as it goes, or at the pace of the wall clock",
    )
    run.add_argument("--duration", type=float, metavar="S", help="simulated time [s]")
    run.add_argument(
        "--processes",
        choices=("separate", "single"),
        default="separate",
        help="one process for each node (default), or all nodes in one",
    )
    run.add_argument("--output", type=Path, metavar="DIR", help="new folder for bag and report")
    run.add_argument("--no-bag", dest="bag", action="store_false", help="record nothing")
    add_recording_options(run)
    run.add_argument(
        "--json", action="store_true", help="print summary.json; without a bag, the pace alone"
    )
    run.set_defaults(command=_run)
    analyze_command = commands.add_parser(
        "analyze",
        help="write report.html and summary.json for a bag",
        description="Analyze a bag; needs no ROS and leaves the bag as it is.",
    )
    analyze_command.add_argument("bag", type=Path, metavar="BAG", help="rosbag2 folder or file")
    analyze_command.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder for the report (default: BAG_report, or BAG_run_N_report)",
    )
    add_topic_options(analyze_command)
    analyze_command.add_argument(
        "--run",
        type=int,
        metavar="N",
        help="which run, from 1, of a bag whose recorder went on while the loop was started again",
    )
    analyze_command.add_argument(
        "--export",
        metavar="FORMATS",
        help="also write figures (png, svg) and signals (csv, parquet); separated by commas",
    )
    add_estimator_options(analyze_command)
    analyze_command.add_argument("--json", action="store_true", help="print summary.json")
    analyze_command.set_defaults(command=_analyze)
    compare = commands.add_parser(
        "compare",
        help="overlay the runs of several bags in one page",
        description="Analyze several bags and set them side by side; needs no ROS.",
    )
    compare.add_argument("bags", nargs="+", type=Path, metavar="BAG", help="rosbag2 folder or file")
    compare.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        default=Path("comparison.html"),
        help="page (default: comparison.html)",
    )
    add_topic_options(compare)
    compare.add_argument("--json", action="store_true", help="print the numbers of all runs")
    compare.set_defaults(command=_compare)
    add_record_command(commands)
    add_recover_command(commands)
    add_evaluate_command(commands)
    bench = commands.add_parser(
        "bench",
        help="measure cores and transport beside a peer and a floor",
        description="Medians of one run on this machine, with ratios to a reference.",
    )
    bench.add_argument("names", nargs="*", metavar="NAME", help="benchmarks (default: all)")
    bench.add_argument("--json", action="store_true", help="print the results as JSON")
    bench.set_defaults(command=_bench)
    reproduce = commands.add_parser(
        "reproduce",
        help="redo the paper: figures, claims, sweeps",
        description="Redo the simulations of the paper offline, draw figures 2, 3, 4, 6 and 7, and "
        "set its claims beside what was measured. Exit code 1 if one does not hold.",
    )
    reproduce.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        default=Path("reproduction"),
        help="folder for index.html, figures and claims.json (default: reproduction)",
    )
    reproduce.add_argument("--json", action="store_true", help="print claims.json")
    reproduce.set_defaults(command=_reproduce)
    design = commands.add_parser(
        "design",
        help="design the PID and draw Bode, Nyquist and step response",
        description="Repeat the design behind the default gains: first gain crossover at "
        "10 rad/s, phase margins of 10 degrees or more, smallest maximum sensitivity.",
    )
    design.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        default=Path("design.png"),
        help="picture (default: design.png)",
    )
    design.add_argument("--json", action="store_true", help="print gains and margins as JSON")
    design.set_defaults(command=_design)
    return parser


if __name__ == "__main__":
    main()
