"""A motor, its amplifier and a sensor behind a serial port, as a drive."""

import time
from collections import deque

import numpy as np

from bdt_driver.drive import Reading
from bdt_driver.guarded_drive import DriveError
from bdt_serial_drive.frames import Frame
from bdt_serial_drive.messages import (
    PROTOCOL_VERSION,
    Identity,
    Kind,
    Samples,
    begin_payload,
    read_identity,
    read_samples,
    voltage_payload,
)
from bdt_serial_drive.sample_sequence import SampleSequence
from bdt_serial_drive.serial_line import SerialLine

SHORTEST_WRITE_TIMEOUT = 0.05
"""Time [s] that a port may take for its bytes, whatever the watchdog: adapters have buffers."""

ASKING_PERIOD = 0.1
"""Time [s] after which a device that has not answered is asked again."""


class SerialDrive:
    """A drive that speaks the serial protocol; the driver's parameters ``drive.*`` make one.

    Parameters
    ----------
    port : str
        Serial port.
    baud_rate : int
        Bits per second of a port that has such.
    watchdog : float
        Time [s] without a voltage after which the device takes it off the motor by itself.
    answer_timeout : float
        Longest time [s] in which the device answers when the drive is opened.

    Attributes
    ----------
    identity : Identity or None
        What the device says of itself; None before it is open.
    """

    def __init__(
        self,
        port: str = "/dev/ttyUSB0",
        baud_rate: int = 921600,
        watchdog: float = 0.1,
        answer_timeout: float = 1.0,
    ) -> None:
        if not 0.001 <= watchdog <= 60.0:
            raise DriveError(f"drive.watchdog = {watchdog!r} s: must be 0.001 to 60 s")
        self._port, self._baud_rate = port, int(baud_rate)
        self._watchdog, self._answer_timeout = watchdog, answer_timeout
        self._line: SerialLine | None = None
        self._waiting: deque[tuple[int, Samples]] = deque()
        self._sequence = SampleSequence()
        self._position = self._voltage = 0.0
        self.identity: Identity | None = None

    def open(self) -> None:
        """Open the port and wait until the device has told who it is, and its first sample."""
        self.close()
        # A device that has taken no bytes for as long has no voltage on the motor any more.
        patience = max(self._watchdog, SHORTEST_WRITE_TIMEOUT)
        self._line = SerialLine(self._port, self._baud_rate, patience)
        self._waiting.clear()
        self._sequence, self.identity = SampleSequence(), None
        end = time.monotonic() + self._answer_timeout
        while self.identity is None or not self._waiting:
            if time.monotonic() > end:
                raise DriveError(
                    f"port {self._port}: no answer for {self._answer_timeout:g} s: is it the right "
                    f"device, with the right baud rate ({self._baud_rate})?"
                )
            if self.identity is None:
                self._connected().send(Kind.BEGIN, begin_payload(self._watchdog))
            self._take(self._connected().receive(ASKING_PERIOD))

    def read(self) -> Reading:
        """Return the samples that have come; those behind a hole wait for the next reading."""
        self._take(self._connected().receive())
        rows, lost = [np.empty((0, 2))], 0
        while self._waiting and (len(rows) == 1 or not self._waiting[0][0]):
            missing, samples = self._waiting.popleft()
            lost += missing
            rows.append(samples.rows)
        joined = np.concatenate(rows)
        if len(joined):
            self._voltage, self._position = map(float, joined[-1])
        return Reading(self._position, self._voltage, joined, lost)

    def write(self, voltage: float) -> None:
        """Send a voltage [V]; the device limits it and tells in its samples what it applies."""
        self._connected().send(Kind.VOLTAGE, voltage_payload(voltage))

    def stop(self) -> None:
        """Take the voltage off; twice, for the line may lose a frame."""
        if self._line is not None:
            for _ in range(2):
                self._line.send(Kind.STOP)

    def close(self) -> None:
        """Tell the device that this was all, and give the port back."""
        line, self._line = self._line, None
        if line is not None:
            try:
                line.send(Kind.END)
            finally:
                line.close()

    def _connected(self) -> SerialLine:
        if self._line is None:
            raise DriveError(f"port {self._port}: is not open")
        return self._line

    def _take(self, frames: list[Frame]) -> None:
        for frame in frames:
            if frame.kind == Kind.IDENTITY and (identity := read_identity(frame.payload)):
                if identity.version != PROTOCOL_VERSION:
                    raise DriveError(
                        f"port {self._port}: the device speaks version {identity.version} of the "
                        f"protocol: must be {PROTOCOL_VERSION}"
                    )
                self.identity = identity
            elif frame.kind == Kind.SAMPLES and (samples := read_samples(frame.payload)):
                placed = self._sequence.placed(samples)
                self._waiting += [placed] if placed else []
