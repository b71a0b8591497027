"""The end of a child process: asked first, then forced, never waited for without a limit."""

import contextlib
import signal
import subprocess
from collections.abc import Sequence
from typing import Any

STOP_DEADLINES = ((signal.SIGINT, 15.0), (signal.SIGTERM, 3.0), (signal.SIGKILL, 3.0))
"""Signals that end a node, each sent once, and the time each one has to work [s]."""


class ProcessEnd:
    """Ends a process with signals of growing force.

    Parameters
    ----------
    process : subprocess.Popen
        The process.
    deadlines : sequence of (signal.Signals, float)
        Signals in the order in which they are sent, and the time each one has to work [s].
    """

    def __init__(
        self,
        process: "subprocess.Popen[Any]",
        deadlines: Sequence[tuple[signal.Signals, float]] = STOP_DEADLINES,
    ) -> None:
        self._process = process
        self._deadlines = deadlines
        self._sent: set[signal.Signals] = set()

    def ask(self) -> None:
        """Send the first signal and return at once."""
        self._send_once(self._deadlines[0][0])

    def wait(self) -> int:
        """End the process, with more force as time goes by, and return its exit code.

        Raises
        ------
        RuntimeError
            If it outlives the last signal and its time.
        """
        for number, patience in self._deadlines:
            self._send_once(number)
            with contextlib.suppress(subprocess.TimeoutExpired):
                return self._process.wait(patience)
        raise RuntimeError(f"process {self._process.pid} does not end")

    def _send_once(self, number: signal.Signals) -> None:
        # A second SIGINT would hit a node in the middle of its teardown.
        if number not in self._sent and self._process.poll() is None:
            self._sent.add(number)
            self._process.send_signal(number)
