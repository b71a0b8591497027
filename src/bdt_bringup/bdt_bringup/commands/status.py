"""The command ``bdt status``: the state of a loop that runs, in one word with its reason."""

import time
from argparse import ArgumentParser, Namespace
from datetime import datetime

from bdt_msgs_py.command_errors import FAILED
from bdt_msgs_py.commands import Command


def _add_arguments(parser: ArgumentParser) -> None:
    parser.add_argument("--namespace", metavar="NAME", help="namespace of the loop")
    parser.add_argument(
        "--watch", action="store_true", help="print a line for each change until Ctrl-C"
    )


def _status(options: Namespace) -> int:
    # The list of commands needs no ROS.
    from bdt_bringup.loop_health import LoopHealth  # noqa: PLC0415
    from bdt_bringup.loop_state import NODES, OK  # noqa: PLC0415
    from bdt_bringup.status import ChangesOfState, watch_loop  # noqa: PLC0415
    from bdt_msgs_py.loop_namespace import full_namespace  # noqa: PLC0415

    words: list[str] = []
    changes = ChangesOfState()

    def tell(health: LoopHealth) -> bool:
        state = health.state
        if options.watch:
            if changes.is_news(state):
                stamp = datetime.now().astimezone().strftime("%H:%M:%S")
                print(f"{stamp} {state}", flush=True)
            return True
        words.append(state.word)
        print(state)
        now = time.monotonic()
        for name in NODES:
            if (report := health.reports.get(name)) is not None:
                level = ("ok", "warning", "error")[min(report.level, 2)]
                age = now - report.heard
                print(f"  {name:<10} {level:<7} {report.text} ({age:.1f} s ago)")
        return False

    watch_loop(full_namespace(options.namespace), tell)
    return 0 if words == [OK] else FAILED


COMMAND = Command(
    summary="the state of a running loop: ok, degraded or stopped, and why",
    description="Print the state of a running loop in one word, with the node that is the cause "
    "and its reason, and what each node says. The exit code is 0 if it is ok, else 1.",
    add_arguments=_add_arguments,
    run=_status,
)
