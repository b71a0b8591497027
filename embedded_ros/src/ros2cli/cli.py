"""Entry point of ``ros2``: finds the group and verb, and calls it."""

import argparse
import os
import signal
import sys
from collections.abc import Sequence

from rclpy.executors import ExternalShutdownException
from ros2cli import bag, doctor, interface, node, param, pkg, run, service, topic

__all__ = ["main"]

_GROUPS = (bag, doctor, interface, node, param, pkg, run, service, topic)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="ros2", description="ros2 is an extensible command-line tool for ROS 2."
    )
    groups = parser.add_subparsers(
        title="Commands", metavar="Call `ros2 <command> -h` for more detailed usage."
    )
    for group in _GROUPS:
        group.add_commands(groups)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Parameters
    ----------
    argv : sequence of str, optional
        ``sys.argv`` without the program by default.

    Returns
    -------
    int
        Exit code. A command that a signal ends returns the number of the signal, as in Jazzy.
    """
    parser = _parser()
    arguments = parser.parse_args(argv)
    if not hasattr(arguments, "main"):
        # Like Jazzy's: `ros2` and `ros2 topic` alone explain themselves and succeed.
        getattr(arguments, "parser", parser).print_help()
        return 0
    try:
        code: int | None = arguments.main(arguments)
        sys.stdout.flush()
    except KeyboardInterrupt:
        return signal.SIGINT
    except ExternalShutdownException:
        return signal.SIGTERM
    except BrokenPipeError:
        # The reader has gone; Python must not complain when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return 1
    return code or 0
