"""``ros2 run``: run an executable of a package."""

import argparse
import os
import sys
from typing import Any

from ros2cli.executables import find_executable

__all__ = ["add_commands"]

# What a console script does, without the script: it need not be on the path.
_LAUNCH = (
    "import sys; from importlib import import_module; from operator import attrgetter; "
    "sys.argv[0] = {name!r}; "
    "sys.exit(attrgetter({attribute!r})(import_module({module!r}))())"
)


def add_commands(groups: Any) -> None:
    """Add the command to the parser."""
    parser = groups.add_parser("run", help="Run a package specific executable")
    parser.add_argument("--prefix", help="Prefix command, which should go before the executable")
    parser.add_argument("package_name", help="Name of the ROS package")
    parser.add_argument("executable_name", help="Name of the executable")
    parser.add_argument(
        "argv", nargs=argparse.REMAINDER, help="Pass arbitrary arguments to the executable"
    )
    parser.set_defaults(main=_run)


def _run(arguments: argparse.Namespace) -> int:
    entry = find_executable(arguments.package_name, arguments.executable_name)
    code = _LAUNCH.format(name=entry.name, attribute=entry.attr, module=entry.module)
    command = [sys.executable, "-c", code, *arguments.argv]
    if arguments.prefix:
        command = [*arguments.prefix.split(), *command]
    # The executable replaces this process: signals and the exit code are its own.
    os.execvp(command[0], command)  # noqa: S606
