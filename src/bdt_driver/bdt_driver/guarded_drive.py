"""Somebody's drive as one that the driver node can rely on: found, watched, its faults told."""

import math
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bdt_driver.drive import Reading
from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.user_code import UserCode, binds

LOOKS_PER_TIMEOUT = 8


class DriveError(BadInputError):
    """Somebody's drive cannot be made or has failed: one line with its file and line."""


class GuardedDrive:
    """A drive from outside this project.

    A second thread watches every call. One that lasts too long cannot be ended, but the voltage
    can: the thread calls the drive's ``stop``.

    Parameters
    ----------
    kind : str
        ``module:name`` of a class, see :class:`bdt_driver.drive.Drive`.
    options : mapping
        Arguments of the class by name.
    call_timeout : float
        Time that a call may last [s].
    on_late : callable
        Gets a line, in the second thread, when a call lasts longer.
    brings_samples : bool
        Whether a reading has samples of the hardware.

    Attributes
    ----------
    drive : object
        What the class has made.

    Raises
    ------
    DriveError
        If there is no such module or class, if it fails, or has not the methods of a drive.
    """

    def __init__(
        self,
        kind: str,
        options: Mapping[str, Any],
        call_timeout: float,
        on_late: Callable[[str], None],
        *,
        brings_samples: bool = False,
    ) -> None:
        self._code = code = UserCode(kind, DriveError)
        if not binds(code.factory, **options):
            given = ", ".join(f"drive.{name}" for name in options) or "no parameter drive.*"
            code.fail(code.factory, f"does not take {given}")
        with code.errors_in_one_line():
            drive = code.factory(**options)
        self.drive = drive
        self._open = code.method(drive, "open", takes="")
        self._read = code.method(drive, "read", takes="")
        self._write = code.method(drive, "write", 0.0, takes="one voltage")
        self._stop = code.method(drive, "stop", takes="")
        self._close = code.method(drive, "close", takes="")
        self._call_timeout = call_timeout
        self._on_late = on_late
        self._brings_samples = brings_samples
        self._call: tuple[str, float] | None = None
        self._late = ""
        self._ended = threading.Event()
        self._watch = threading.Thread(target=self._watch_calls, name="drive-watch", daemon=True)
        self._watch.start()

    def open(self) -> None:
        """Connect.

        Raises
        ------
        DriveError
            For any fault of the drive; so do the other methods.
        """
        with self._called("open"):
            self._open()

    def read(self) -> Reading:
        """Return what the drive has measured."""
        with self._called("read"):
            found = self._read()
        try:
            given = Reading(*found)
            reading = given._replace(
                position=float(given.position), voltage=float(given.voltage), lost=int(given.lost)
            )
        except (TypeError, ValueError):
            self._code.fail(
                self._read, f"read returned {found!r}: must be position, voltage and samples if any"
            )
        samples = self._samples(given.samples) if self._brings_samples else None
        return reading._replace(samples=samples)

    def _samples(self, given: Any) -> NDArray[np.float64]:
        try:
            samples = np.asarray(given, dtype=float)
        except (TypeError, ValueError):
            samples = np.empty(0)
        if samples.ndim != 2 or samples.shape[1] != 2 or not np.isfinite(samples).all():
            self._code.fail(
                self._read,
                f"read returned samples of shape {np.shape(given)}: must be (n, 2), voltages and "
                "positions, finite (sampling_rate 0 is for a drive without samples)",
            )
        return samples

    def write(self, voltage: float) -> None:
        """Apply a voltage [V]."""
        with self._called("write"):
            self._write(voltage)

    def stop(self) -> None:
        """Take the voltage off the motor."""
        with self._called("stop"):
            self._stop()

    def close(self) -> None:
        """Disconnect."""
        with self._called("close"):
            self._close()

    def end(self) -> None:
        """Watch no more calls."""
        self._ended.set()
        self._watch.join()

    @contextmanager
    def _called(self, name: str) -> Iterator[None]:
        self._call = name, time.monotonic()
        try:
            with self._code.errors_in_one_line():
                yield
        except DriveError:
            self._late = ""  # what the call itself says is told
            raise
        finally:
            self._call = None
        # Kept until it is told: the second thread may find a call late as it returns.
        late, self._late = self._late, ""
        if late:
            self._code.fail(self._code.factory, late)

    def _watch_calls(self) -> None:
        # Looks now and then: a wake-up for each call would cost more than the call.
        while not self._ended.wait(self._call_timeout / LOOKS_PER_TIMEOUT):
            call = self._call
            if call is None or self._late or call[0] in ("open", "close"):
                continue
            name, began = call
            if time.monotonic() - began <= self._call_timeout:
                continue
            late = f"{name} lasts longer than {self._call_timeout:g} s: stopped"
            try:
                self._stop()
            except Exception as error:  # noqa: BLE001 - told with the fault
                late += f", and stop failed: {type(error).__name__}: {error}"
            self._late = late
            self._on_late(late)


def is_readable(reading: Reading) -> bool:
    """Tell whether position and voltage of a reading are numbers."""
    return math.isfinite(reading.position) and math.isfinite(reading.voltage)
