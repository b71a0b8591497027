"""``ros2``: reads the command line, calls what it names, and tells how that ended."""

import os
import signal
import sys
from collections.abc import Sequence
from pkgutil import resolve_name

from ros2cli.errors import CommandError, Terminated, one_line

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Parameters
    ----------
    argv : sequence of str, optional
        ``sys.argv`` without the program by default.

    Returns
    -------
    int
        Exit code: 0, 1 for what could not be done, 2 for what cannot be typed. As in Jazzy a
        signal that ends a command gives its number.
    """
    try:
        code = _answer(argv)
        # What is still in a buffer may find that its reader has gone: now, not at exit.
        sys.stdout.flush()
        sys.stderr.flush()
    except BrokenPipeError:
        # Python flushes once more at exit, and would complain.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for stream in (sys.stdout, sys.stderr):
            os.dup2(nowhere, stream.fileno())
        return 1
    return code


def _answer(argv: Sequence[str] | None) -> int:
    try:
        # Imported here, so that Ctrl-C ends a command without a word from its beginning on.
        from ros2cli.commands import COMMANDS
        from ros2cli.grammar import build_parser

        arguments = build_parser("ros2", "Talk to ROS 2 nodes.", COMMANDS).parse_args(argv)
        call = arguments.call
        if isinstance(call, str):
            call = resolve_name(f"ros2cli.{call}")
        return int(call(arguments) or 0)
    except KeyboardInterrupt:
        return signal.SIGINT
    except Terminated:
        return signal.SIGTERM
    except SystemExit as end:
        # argparse has told what was wrong, or has shown help.
        return int(end.code or 0)
    except CommandError as error:
        print(error, file=sys.stderr)
    except RuntimeError as error:
        # What rclpy refuses: an environment or a request that it cannot serve.
        print(one_line(error), file=sys.stderr)
    return 1
