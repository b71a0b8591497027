"""The command ``bdt sweep``: many closed loops, what they tell, and one of them again."""

from argparse import ArgumentParser, Namespace
from pathlib import Path

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.commands import Command
from bdt_study.commands.engine_options import add_resume, add_scheduler, add_workers
from bdt_study.engine.optional_packages import DATA_SETS, INDICES, check_imports


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "what",
        metavar="STUDY | report | replay",
        help="the study to run, a YAML file or one that comes with the package (friction_gap, "
        "gains_damping, gap_dead_zone, gap_delay); report DIR writes its page, replay DIR RUN runs "
        "the nodes with the parameters of one of its runs, with a bag and a report",
    )
    parser.add_argument("of", nargs="*", metavar="DIR [RUN]", help="of report and replay")
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder of the data set (default: sweeps/NAME OF THE STUDY), of the replayed run, or "
        "file of the page",
    )
    add_workers(parser)
    add_scheduler(parser)
    add_resume(parser)
    parser.add_argument(
        "--dry-run",
        action="store_true",
        help="check the study, say how many runs it has, how long it takes and how large it gets",
    )
    parser.add_argument("--json", action="store_true", help="print the outcome as JSON")


def _sweep(options: Namespace) -> int:
    check_imports("bdt sweep", DATA_SETS)
    # The list of commands needs neither numba nor pyarrow.
    if options.what == "report":
        check_imports("bdt sweep report", INDICES)
        from bdt_study.sweep.report_sweep import report  # noqa: PLC0415

        (folder,) = _checked(options, "DIR")
        return report(Path(folder), options.output, as_json=options.json)
    if options.what == "replay":
        from bdt_study.sweep.replay import replay  # noqa: PLC0415

        folder, run = _checked(options, "DIR", "RUN")
        if not run.isdecimal():
            raise BadInputError(f"bdt sweep replay: RUN {run!r}: must be the number of a run")
        return replay(Path(folder), int(run), options.output, as_json=options.json)
    from bdt_study.sweep.run_sweep import sweep  # noqa: PLC0415

    _checked(options)
    return sweep(options)


def _checked(options: Namespace, *names: str) -> list[str]:
    """Return the arguments after the first one, as many as there are names for."""
    if len(options.of) != len(names):
        wanted = " ".join([options.what, *names])
        raise BadInputError(f"bdt sweep {' '.join([options.what, *options.of])}: must be {wanted}")
    return list(options.of)


COMMAND = Command(
    summary="run a study: many loops over parameters, on all cores or a cluster",
    description="Run closed loops over grids, ranges and samples of parameters on all cores or "
    "on the workers of a Dask scheduler, into a Parquet data set that can be read at any moment "
    "and resumed after any end.",
    add_arguments=_add_arguments,
    run=_sweep,
)
