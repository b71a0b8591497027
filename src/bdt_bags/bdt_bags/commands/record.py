"""The command ``bdt record``: the recorder node alone, beside a loop that runs."""

import sys
from argparse import ArgumentParser, Namespace
from dataclasses import asdict
from datetime import datetime
from pathlib import Path

from bdt_bags.recorder.recorder_settings import RECORDING_OPTIONS, RecorderSettings
from bdt_msgs_py.command_errors import FAILED, BadInputError, complain
from bdt_msgs_py.commands import Command
from bdt_msgs_py.parameter_tables import ros_arguments
from bdt_msgs_py.quantity_options import add_quantity_options, quantities_from_options

NODE_NAME = "bag_recorder"
"""Not ``recorder``: a lockstep plant must not take this one for the one that it waits for."""


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("topics", nargs="*", metavar="TOPIC", help="topics (default: the loop's)")
    parser.add_argument(
        "--output", type=Path, metavar="DIR", help="new bag folder (default: bag-<time>)"
    )
    parser.add_argument("--namespace", metavar="NAME", help="namespace of the loop")
    add_quantity_options(parser, RecorderSettings, RECORDING_OPTIONS)


def _record(options: Namespace) -> int:
    # The list of commands needs no ROS.
    from bdt_bags.recorder.recorder_node import (  # noqa: PLC0415
        RecorderNode,
        record_until_stopped,
    )
    from bdt_msgs_py.loop_namespace import full_namespace, namespace_arguments  # noqa: PLC0415
    from bdt_msgs_py.node_main import run_node  # noqa: PLC0415

    begun = datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")
    bag = options.output or Path(f"bag-{begun}")
    if bag.exists():
        raise BadInputError(f"--output {bag}: exists already, must be a new folder")
    settings = quantities_from_options(
        RecorderSettings, options, RECORDING_OPTIONS, bag=str(bag), topics=" ".join(options.topics)
    )
    arguments = ["bdt", "--ros-args", "-r", f"__node:={NODE_NAME}"]
    arguments += namespace_arguments(full_namespace(options.namespace))
    arguments += ros_arguments(asdict(settings))
    created: list[RecorderNode] = []

    def create() -> RecorderNode:
        created.append(RecorderNode())
        print(f"recording to {bag}, Ctrl-C to stop", file=sys.stderr)
        return created[-1]

    code = run_node(create, arguments, spin=record_until_stopped)
    if created:
        print(f"{created[-1].summary}\nbag: {bag}")
        if not code and created[-1].dropped:
            return complain(f"--output {bag}: is incomplete, the disk did not take all", FAILED)
    return code


COMMAND = Command(
    summary="record a running loop into a bag until Ctrl-C",
    description="Record the topics of this project, or those that are named, of whatever "
    "node, until Ctrl-C.",
    add_arguments=_add_arguments,
    run=_record,
)
