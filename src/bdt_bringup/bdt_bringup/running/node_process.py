"""A node as a child process: started, watched, stopped, with its output in a log file."""

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

STOP_DEADLINES = ((signal.SIGINT, 15.0), (signal.SIGTERM, 3.0), (signal.SIGKILL, 3.0))
"""Signals that end a node, each sent once, and the time each one has to work [s]."""


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
        self._sent: set[signal.Signals] = set()
        guard = [sys.executable, "-m", "bdt_bringup.running.guarded_node", str(os.getpid()), module]
        command = [*guard, "--ros-args", *ros_arguments]
        with log.open("wb") as output:
            self._process = subprocess.Popen(  # noqa: S603
                command,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                # Ctrl-C in a terminal reaches `bdt run` alone, which then stops the nodes in order.
                start_new_session=True,
            )

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
        self._send_once(signal.SIGINT)

    def stop(self) -> int:
        """End the process, with more force as time goes by, and return its exit code."""
        for number, patience in STOP_DEADLINES:
            self._send_once(number)
            with contextlib.suppress(subprocess.TimeoutExpired):
                return self._process.wait(patience)
        raise RuntimeError(f"process {self.pid} of node {self.name} does not end")

    def _send_once(self, number: signal.Signals) -> None:
        # A second SIGINT would hit a node in the middle of its teardown.
        if number not in self._sent and self.exit_code is None:
            self._sent.add(number)
            self._process.send_signal(number)


def stop_all(processes: Sequence[NodeProcess]) -> None:
    """Interrupt all processes at once, then wait for each."""
    for process in processes:
        process.interrupt()
    for process in processes:
        process.stop()
