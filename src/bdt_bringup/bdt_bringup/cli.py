"""The command ``bdt``: finds its subcommands in the packages that are installed."""

import argparse
import os
import sys
from collections.abc import Mapping, Sequence
from typing import Never

from bdt_bringup.closed_pipe import quiet_when_nobody_reads
from bdt_bringup.installed import PACKAGE_OF_COMMAND, installed_commands
from bdt_msgs_py.command_errors import (
    BAD_INPUT,
    FAILED,
    INTERRUPTED,
    BadInputError,
    LoopError,
    complain,
)
from bdt_msgs_py.commands import Command


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command and end the process with its exit code."""
    # Matrices have some ten rows here: threads of a linear-algebra library would only wait for
    # each other, on a busy computer for seconds.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with quiet_when_nobody_reads():
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
    try:
        options = command_parser(installed_commands()).parse_args(arguments)
        return int(options.run_subcommand(options))
    except BadInputError as error:
        return complain(error, BAD_INPUT)
    except LoopError as error:
        return complain(error, FAILED)
    except KeyboardInterrupt:
        return complain("interrupted", INTERRUPTED)
    except OSError as error:
        # Without a name it is a pipe or standard output, or a fault of this program.
        if error.filename is None:
            raise
        return complain(f"{error.filename}: {error.strerror}", BAD_INPUT)
    except Exception as error:
        if not _came_from_interrupt(error):
            raise
        return complain("interrupted", INTERRUPTED)


def _came_from_interrupt(error: BaseException | None) -> bool:
    """Tell whether Ctrl-C is behind an error: a library may turn it into one of its own."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


class _CommandParser(argparse.ArgumentParser):
    """A parser that knows which package has a subcommand that is not installed."""

    def error(self, message: str) -> Never:
        """End the program with usage and message."""
        for name, package in PACKAGE_OF_COMMAND.items():
            if f"invalid choice: {name!r}" in message:
                message = f"{name}: is a command of the package {package}, install it"
        super().error(message)


def command_parser(commands: Mapping[str, Command]) -> argparse.ArgumentParser:
    """Return the parser of ``bdt``.

    Parameters
    ----------
    commands : mapping of str to Command
        Subcommands by name, in the order of the help.
    """
    parser = _CommandParser(
        prog="bdt",
        description="Position control of a flexible structure whose lead screw wears out: "
        "plant, dead-zone controller and digital twin as ROS 2 nodes.",
    )
    subparsers = parser.add_subparsers(
        title="commands", required=True, metavar="COMMAND", parser_class=argparse.ArgumentParser
    )
    for name, command in commands.items():
        subparser = subparsers.add_parser(
            name, help=command.summary, description=command.description
        )
        command.add_arguments(subparser)
        subparser.set_defaults(run_subcommand=command.run)
    return parser


if __name__ == "__main__":
    main()
