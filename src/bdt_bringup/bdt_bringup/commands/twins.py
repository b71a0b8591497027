"""The command ``bdt twins``: the twins of many machines on one computer."""

import os
from argparse import ArgumentParser, Namespace
from pathlib import Path

from bdt_msgs_py.commands import Command


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "machines",
        nargs="+",
        metavar="NAMESPACE[=CONFIG]",
        help="namespace of a machine's nodes; with a configuration of its own behind =",
    )
    parser.add_argument(
        "--config",
        metavar="NAME|FILE",
        help="configuration of all twins that have none of their own; defaults without it",
    )
    parser.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="most processes that share the twins; as many as there are cores without it",
    )
    parser.add_argument(
        "--states",
        type=Path,
        metavar="DIR",
        help="folder in which each twin keeps what it knows and what is in force, for a new start",
    )
    parser.add_argument(
        "--sim-time",
        action="store_true",
        help="the machines are simulated, each with a clock in its namespace",
    )


def _twins(options: Namespace) -> int:
    # The list of commands needs no YAML parser.
    from bdt_bringup.fleet import run_fleet  # noqa: PLC0415
    from bdt_bringup.fleet_plan import plan_fleet, shared_out  # noqa: PLC0415
    from bdt_msgs_py.folder_sync import create_folder  # noqa: PLC0415
    from bdt_msgs_py.output_files import not_writable  # noqa: PLC0415

    twins = plan_fleet(
        options.machines,
        config=options.config,
        states=options.states,
        use_sim_time=options.sim_time,
    )
    cores = len(os.sched_getaffinity(0))
    shares = shared_out(twins, cores if options.workers is None else options.workers)
    if options.states is not None:
        try:
            create_folder(options.states)
        except OSError as error:
            raise not_writable("--states", options.states, error) from error
    return run_fleet(shares)


COMMAND = Command(
    summary="run the twins of many machines on this computer",
    description="Run a twin for each machine, in a few processes, until Ctrl-C. A twin that fails "
    "is started anew, and takes no other with it.",
    add_arguments=_add_arguments,
    run=_twins,
)
