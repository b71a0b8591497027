"""The command ``bdt run``: the whole loop, from a configuration to a report."""

import json
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from bdt_bringup.installed import installed_commands, missing_packages, parameter_table
from bdt_bringup.loop_state import MACHINES
from bdt_msgs_py.command_errors import INTERRUPTED, complain
from bdt_msgs_py.commands import Command
from bdt_msgs_py.quantity_options import add_quantity_options, quantities_from_options
from bdt_msgs_py.topics import RECORDER_NODE

RECORDING_OPTIONS = ("storage", "compression", "split_size", "split_duration")
"""Parameters of the recorder that are options of ``bdt run``."""

REPORT_COMMAND = "analyze"


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--config",
        metavar="NAME|FILE",
        help="configuration that comes with the package (paper, linear, fixed_dead_zone, "
        "laboratory, workshop, serial_drive), or a ROS parameter file",
    )
    parser.add_argument(
        "--namespace",
        metavar="NAME",
        help="namespace of all nodes, topics and of the clock, so that several loops can run in "
        "one ROS domain",
    )
    parser.add_argument(
        "--machine",
        choices=MACHINES,
        help="which one, for a configuration that has a simulated machine and a real one",
    )
    parser.add_argument(
        "--mode",
        choices=("lockstep", "realtime"),
        help="simulated time as fast as it goes, or at the pace of the wall clock",
    )
    parser.add_argument(
        "--duration",
        type=float,
        metavar="S",
        help="simulated time, or time for which a real machine is armed [s]",
    )
    parser.add_argument(
        "--processes",
        choices=("separate", "shared", "single"),
        default="separate",
        help="one process for each node (default); one that driver and controller of a real "
        "machine share, so that a command comes sooner; or all nodes in one",
    )
    parser.add_argument(
        "--supervise",
        action="store_true",
        help="start nodes anew that died, save the plant: after 0.25 s, then twice as long each "
        "time, 5 times within 60 s",
    )
    parser.add_argument("--output", type=Path, metavar="DIR", help="new folder for bag and report")
    parser.add_argument("--no-bag", dest="bag", action="store_false", help="record nothing")
    if not missing_packages([RECORDER_NODE]):
        add_quantity_options(parser, _recorder_settings(), RECORDING_OPTIONS)
    parser.add_argument(
        "--json", action="store_true", help="print summary.json; without a bag, the pace alone"
    )


def _run(options: Namespace) -> int:
    # The list of commands needs neither rclpy nor a YAML parser.
    from bdt_bringup.configuration import load_configuration  # noqa: PLC0415
    from bdt_bringup.run import run_loop  # noqa: PLC0415
    from bdt_bringup.run_plan import plan_run  # noqa: PLC0415
    from bdt_msgs_py.configuration_files import find_configuration  # noqa: PLC0415
    from bdt_msgs_py.loop_namespace import full_namespace  # noqa: PLC0415

    plan = plan_run(
        load_configuration(
            find_configuration(options.config),
            full_namespace(options.namespace),
            options.machine,
        ),
        mode=options.mode,
        duration=options.duration,
        processes=options.processes,
        output=options.output,
        recorder=_recorder_parameters(options) if options.bag else None,
        supervise=options.supervise,
    )
    try:
        factor = run_loop(plan)
    except KeyboardInterrupt:
        kept = f"; what was recorded is in {plan.bag}" if plan.record else ""
        return complain(f"interrupted{kept}", INTERRUPTED)
    if len(plan.bags) > 1:
        print(f"bags, as the recorder was started anew: {' '.join(map(str, plan.bags))}")
        return 0
    if plan.record:
        return _report(plan.bag, plan.output, as_json=options.json)
    if options.json:
        print(json.dumps({"duration": plan.duration, "real_time_factor": factor}, indent=2))
    return 0


def _recorder_parameters(options: Namespace) -> dict[str, object]:
    if missing_packages([RECORDER_NODE]):
        # The plan refuses it, with the packages of all nodes that are missing.
        return {}
    chosen = quantities_from_options(_recorder_settings(), options, RECORDING_OPTIONS)
    return {name: getattr(chosen, name) for name in RECORDING_OPTIONS}


def _recorder_settings() -> type[Any]:
    ((_, settings),) = parameter_table(RECORDER_NODE)
    return settings


def _report(bag: Path, output: Path, *, as_json: bool) -> int:
    """Analyze the bag, where the package that does it is installed."""
    command = installed_commands().get(REPORT_COMMAND)
    if command is None:
        print(f"bag: {bag}")
        return 0
    parser = ArgumentParser()
    command.add_arguments(parser)
    arguments = [str(bag), "--output", str(output), *(["--json"] if as_json else [])]
    return command.run(parser.parse_args(arguments))


COMMAND = Command(
    summary="start the nodes, record a bag, write a report",
    description="Start plant or driver, controller, twin and recorder, and analyze what they "
    "recorded.",
    add_arguments=_add_arguments,
    run=_run,
)
