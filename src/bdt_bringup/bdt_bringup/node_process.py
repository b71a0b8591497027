"""A node as a child process: started, watched, stopped, with its output in a log file."""

import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Protocol

from bdt_msgs_py.process_end import ProcessEnd


def start_guarded(
    arguments: Sequence[str], log: IO[bytes] | None = None
) -> subprocess.Popen[bytes]:
    """Start a Python module that ends when this program has gone, however that went.

    Parameters
    ----------
    arguments : sequence of str
        The module, which has a ``main``, and what follows it on its command line.
    log : file, optional
        Takes standard output and error, which go where those of this program do without it.
    """
    guard = [sys.executable, "-m", "bdt_bringup.child_node", str(os.getpid())]
    return subprocess.Popen(  # noqa: S603
        [*guard, *arguments],
        stdin=subprocess.DEVNULL,
        # Ctrl-C in a terminal reaches this program alone, which then stops its children in order.
        start_new_session=True,
        stdout=log,
        stderr=None if log is None else subprocess.STDOUT,
    )


class Stoppable(Protocol):
    """A process that ends when it is asked to."""

    def interrupt(self) -> None:
        """Ask the process to end."""

    def stop(self) -> object:
        """End the process, with more force as time goes by."""


class NodeProcess:
    """One node in a process of its own.

    Parameters
    ----------
    name : str
        Name of the node, for messages.
    module : str
        Python module with the node's ``main``.
    ros_arguments : sequence of str
        What follows ``--ros-args``.
    log : Path
        File for the node's standard output and error.
    """

    def __init__(self, name: str, module: str, ros_arguments: Sequence[str], log: Path) -> None:
        self.name = name
        self.log = log
        # What a node said before it was started anew is of interest.
        with log.open("ab") as output:
            self._process = start_guarded([module, "--ros-args", *ros_arguments], output)
        self._end = ProcessEnd(self._process)

    @property
    def pid(self) -> int:
        """Process identifier."""
        return self._process.pid

    @property
    def exit_code(self) -> int | None:
        """Exit code, negative for a signal, None while the process runs."""
        return self._process.poll()

    def describe_end(self) -> str:
        """Return how the process ended, in words."""
        code = self.exit_code
        if code is None:
            return "still running"
        if code < 0:
            return f"killed by {signal.Signals(-code).name}"
        return f"exit code {code}"

    def last_lines(self, count: int = 5) -> list[str]:
        """Return the last lines of the node's output."""
        return self.log.read_text(encoding="utf-8", errors="replace").splitlines()[-count:]

    def interrupt(self) -> None:
        """Ask the process to end, as Ctrl-C does."""
        self._end.ask()

    def stop(self) -> int:
        """End the process, with more force as time goes by, and return its exit code."""
        return self._end.wait()


def stop_all(processes: Sequence[Stoppable]) -> None:
    """Interrupt all processes at once, then wait for each."""
    for process in processes:
        process.interrupt()
    for process in processes:
        process.stop()
