"""Writes the twin's state beside it, once a second at most: a disk may take its time."""

import threading
import time
from pathlib import Path

from bdt_twin.state_file import write_state
from bdt_twin.twin_state import TwinState

PERIOD = 1.0
"""Wall time [s] from one writing to the next at least."""
LONGEST_END = 5.0
"""Wall time [s] that the last writing may take."""


class StateWriter:
    """A thread that writes the newest of the states that it is given.

    Parameters
    ----------
    path : Path
        The state file.

    Attributes
    ----------
    error : str
        Why the newest state could not be written; empty if it could.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._newest: TwinState | None = None
        self._ended = False
        self.error = ""
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="state_file", daemon=True)
        self._thread.start()

    def put(self, state: TwinState) -> None:
        """Have a state written, unless a newer one comes before its turn."""
        with self._changed:
            self._newest = state
            self._changed.notify()

    def close(self) -> None:
        """Write what is left to write, and end."""
        with self._changed:
            self._ended = True
            self._changed.notify()
        self._thread.join(LONGEST_END)

    def _run(self) -> None:
        while (state := self._next()) is not None:
            try:
                write_state(self._path, state, time.time())
                self.error = ""
            except OSError as error:
                self.error = f"{self._path}: cannot be written: {error.strerror or error}"
            with self._changed:
                self._changed.wait_for(lambda: self._ended, PERIOD)

    def _next(self) -> TwinState | None:
        """Wait for a state; None at the end, when there is none left."""
        with self._changed:
            self._changed.wait_for(lambda: self._newest is not None or self._ended)
            state, self._newest = self._newest, None
            return state
