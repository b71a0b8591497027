"""The command ``bdt live``: a loop in the browser."""

from argparse import ArgumentParser, Namespace
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.commands import Command

if TYPE_CHECKING:
    from bdt_bringup.run_plan import RunPlan

DEFAULT_PORT = 8765
EVERYWHERE = ("", "0.0.0.0", "::", "*")  # noqa: S104
"""Addresses that are none: by which name a browser calls the server is compared with it."""

ENDLESS = 1e9
"""Duration [s] of a loop that runs until somebody ends it."""


def _add_arguments(parser: ArgumentParser) -> None:
    source = parser.add_mutually_exclusive_group()
    source.add_argument(
        "--config", metavar="NAME|FILE", help="configuration of the loop to start (default: paper)"
    )
    source.add_argument("--attach", action="store_true", help="show a loop that runs already")
    source.add_argument("--bag", type=Path, metavar="BAG", help="play a bag back")
    parser.add_argument("--namespace", metavar="NAME", help="namespace of the loop")
    parser.add_argument(
        "--port",
        type=int,
        default=DEFAULT_PORT,
        metavar="N",
        help="port, 0 for any that is free (default: %(default)s)",
    )
    parser.add_argument(
        "--host", metavar="ADDRESS", help="address to listen on, for other computers as well"
    )
    parser.add_argument(
        "--password-file", type=Path, metavar="FILE", help="its first line is the password"
    )
    parser.add_argument("--open", action="store_true", help="open the page in the browser")
    parser.add_argument("--output", type=Path, metavar="DIR", help="new folder for bags and logs")


def _live(options: Namespace) -> int:
    # The list of commands needs neither rclpy nor a server.
    from bdt_live.access import Access  # noqa: PLC0415
    from bdt_live.run_live import LiveSettings, live_plan, run_live  # noqa: PLC0415
    from bdt_msgs_py.loop_namespace import full_namespace, namespace_arguments  # noqa: PLC0415

    namespace = full_namespace(options.namespace)
    access = Access(options.host or "127.0.0.1", _port(options.port), _password(options))
    ros = ("--ros-args", *namespace_arguments(namespace))
    if options.bag is not None:
        output = _output(options, "playback")
        arguments = (str(options.bag.absolute()),)
        settings = LiveSettings("bdt_live.bag_process", arguments, output)
    elif options.attach:
        output = _output(options, "attached")
        # Whether a loop that runs already waits for anybody is not known.
        settings = LiveSettings("bdt_live.ros_process", ("realtime", *ros), output)
    else:
        plan = live_plan(_plan(options, namespace))
        settings = LiveSettings("bdt_live.ros_process", (plan.mode, *ros), plan.output, plan)
    return run_live(settings, access)


def _plan(options: Namespace, namespace: str) -> "RunPlan":
    from bdt_bringup.configuration import load_configuration  # noqa: PLC0415
    from bdt_bringup.run_plan import plan_run  # noqa: PLC0415
    from bdt_msgs_py.configuration_files import find_configuration  # noqa: PLC0415

    return plan_run(
        load_configuration(find_configuration(options.config or "paper"), namespace),
        mode=None,
        duration=ENDLESS,
        processes="separate",
        output=options.output or _output(options, "live"),
        recorder=None,
        supervise=True,
    )


def _output(options: Namespace, what: str) -> Path:
    if options.output is not None:
        return Path(options.output)
    return Path("runs") / f"{datetime.now().astimezone():%Y%m%d-%H%M%S}-{what}"


def _port(port: int) -> int:
    if not 0 <= port <= 65535:
        raise BadInputError(f"--port {port}: must be 0 to 65535")
    return port


def _password(options: Namespace) -> str | None:
    if (options.host is None) != (options.password_file is None):
        raise BadInputError("--host and --password-file: must be given together")
    if options.password_file is None:
        return None
    if options.host in EVERYWHERE:
        raise BadInputError(f"--host {options.host}: must be one address of this computer")
    try:
        lines = options.password_file.read_text("utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise BadInputError(f"--password-file {options.password_file}: {error}") from error
    if not lines or len(lines[0]) < 8:
        raise BadInputError(
            f"--password-file {options.password_file}: must begin with 8 characters or more"
        )
    return str(lines[0])


COMMAND = Command(
    summary="a loop in the browser: the mechanism moving, running plots, sliders",
    description="Start a loop, or attach to one that runs, or play a bag, and serve a page that "
    "shows it. The address is printed; it opens on this computer alone unless --host says "
    "otherwise.",
    add_arguments=_add_arguments,
    run=_live,
)
