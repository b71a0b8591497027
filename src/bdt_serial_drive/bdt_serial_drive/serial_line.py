"""A serial port that carries frames, and whose troubles are one line each."""

import errno
import select
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import serial

from bdt_driver.guarded_drive import DriveError
from bdt_serial_drive.frames import Frame, FrameReader, encoded


class SerialLine:
    """A serial port that is open and belongs to this process alone.

    Parameters
    ----------
    port : str
        Device, for example ``/dev/ttyUSB0``; a link to one will do.
    baud_rate : int
        Bits per second; of no matter to USB devices and pseudo-terminals.
    write_timeout : float
        Time [s] after which a line that takes no bytes is a fault.

    Raises
    ------
    DriveError
        With one line, if there is no such port, or it is busy or not allowed; so do the methods
        when the cable is pulled.
    """

    def __init__(self, port: str, baud_rate: int, write_timeout: float) -> None:
        self._name, self._write_timeout = port, write_timeout
        self._reader = FrameReader()
        self._sequence = 0
        self._sending = threading.Lock()
        try:
            self._port: Any = serial.Serial(
                port, baud_rate, timeout=0.0, write_timeout=0.0, exclusive=True
            )
        except (serial.SerialException, OSError, ValueError) as error:
            raise DriveError(f"port {port}: {_reason(error)}") from error
        # What an earlier session left is of no use.
        with self._one_line_errors():
            self._port.reset_input_buffer()

    def send(self, kind: int, payload: bytes = b"") -> None:
        """Send a frame; may be called by several threads."""
        with self._sending, self._one_line_errors():
            waiting = encoded(Frame(kind, self._sequence, payload))
            while waiting:
                self._wait_for_room()
                waiting = waiting[self._port.write(waiting) :]
            self._sequence += 1

    def receive(self, timeout: float = 0.0) -> list[Frame]:
        """Return the intact frames that have come, after waiting for the first bytes.

        Parameters
        ----------
        timeout : float
            Longest time to wait [s].
        """
        with self._one_line_errors():
            ready, _, _ = select.select([self._port], [], [], timeout)
            received = self._port.read(self._port.in_waiting or 1) if ready else b""
        return self._reader.feed(received)

    def close(self) -> None:
        """Give the port back."""
        self._port.close()

    def _wait_for_room(self) -> None:
        """Wait until the port takes bytes.

        The time is the kernel's, who looks once more at its end. A clock of this process, as
        pyserial's own timeout has one, takes a busy computer for a device that hangs.
        """
        _, ready, _ = select.select([], [self._port], [], self._write_timeout)
        if not ready:
            raise DriveError(
                f"port {self._name}: takes no bytes for {self._write_timeout:g} s: the device hangs"
            )

    @contextmanager
    def _one_line_errors(self) -> Iterator[None]:
        try:
            yield
        except DriveError:
            raise
        # Closed by another thread, a port has no number any more: a TypeError of pyserial.
        except (serial.SerialException, OSError, TypeError, ValueError) as error:
            raise DriveError(f"port {self._name}: the device is gone: is the cable in?") from error


def _reason(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == errno.ENOENT:
        return "there is no such port: is the cable in, and the name right?"
    if number == errno.EACCES:
        return "permission denied: add yourself to the group that owns it, often dialout"
    if number in (errno.EBUSY, errno.EAGAIN) or "lock port" in str(error):
        return "busy: another program has opened it"
    return " ".join(str(error).split())
