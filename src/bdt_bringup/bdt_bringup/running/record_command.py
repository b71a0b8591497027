"""The command ``bdt record``: the recorder node alone, beside a loop that runs."""

import argparse
import sys
from datetime import datetime
from pathlib import Path
from typing import Any

from bdt_bringup.running.configuration import BadInputError
from bdt_bringup.running.recording_options import (
    add_recording_options,
    recorder_parameters,
    recorder_settings,
)

NODE_NAME = "bag_recorder"
"""Not ``recorder``: a lockstep plant must not take this one for the one that it waits for."""


def add_record_command(commands: Any) -> None:
    """Add the command to the subparsers of ``bdt``."""
    record = commands.add_parser(
        "record",
        help="record a running loop into a bag until Ctrl-C",
        description="Record the topics of this project, or those that are named, of whatever "
        "node, until Ctrl-C.",
    )
    record.add_argument("topics", nargs="*", metavar="TOPIC", help="topics (default: the loop's)")
    record.add_argument(
        "--output", type=Path, metavar="DIR", help="new bag folder (default: bag-<time>)"
    )
    record.add_argument("--namespace", metavar="NAME", help="namespace of the loop")
    add_recording_options(record)
    record.set_defaults(command=_record)


def _record(options: argparse.Namespace) -> int:
    # The other commands need no ROS.
    from bdt_bringup.running.recorder_node import RecorderNode  # noqa: PLC0415
    from bdt_msgs_py.node_main import run_node  # noqa: PLC0415

    begun = datetime.now().astimezone().strftime("%Y%m%d-%H%M%S")
    bag = options.output or Path(f"bag-{begun}")
    if bag.exists():
        raise BadInputError(f"--output {bag}: exists already, must be a new folder")
    settings = recorder_settings(options, str(bag), " ".join(options.topics))
    arguments = ["bdt", "--ros-args", "-r", f"__node:={NODE_NAME}"]
    if options.namespace is not None:
        arguments += ["-r", f"__ns:=/{options.namespace.strip('/')}"]
    for name, value in recorder_parameters(settings).items():
        arguments += ["-p", f"{name}:={value}"]
    created: list[RecorderNode] = []

    def create() -> RecorderNode:
        created.append(RecorderNode())
        print(f"recording to {bag}, Ctrl-C to stop", file=sys.stderr)
        return created[-1]

    code = run_node(create, arguments)
    if created:
        print(f"{created[-1].summary}\nbag: {bag}")
    return code
