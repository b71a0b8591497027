"""The device's side of the serial protocol, around a simulated mechanism; pure, time is given."""

import math

import numpy as np

from bdt_drive_emulator.emulator_settings import EmulatorSettings
from bdt_drive_emulator.line_faults import Fault, LineFaults
from bdt_drive_emulator.mechanism import Mechanism
from bdt_serial_drive.frames import Frame, FrameReader, encoded
from bdt_serial_drive.messages import (
    LARGEST,
    LARGEST_COUNT,
    PROTOCOL_VERSION,
    VOLTAGE_UNIT,
    Identity,
    Kind,
    Samples,
    identity_payload,
    read_begin,
    read_voltage,
    samples_payload,
)

FAULT_KIND = 0x7F
"""Kind of a message by which a computer asks for a fault; its payload is the name."""


class EmulatedDevice:
    """Amplifier, motor, screw, structure and sensor with a serial interface.

    Parameters
    ----------
    mechanism : Mechanism
        What it drives.
    settings : EmulatorSettings
        Its clock, and its transport.

    Attributes
    ----------
    faults : LineFaults
        What is wrong with it.
    is_streaming : bool
        Whether a computer has begun and samples are sent.
    """

    def __init__(self, mechanism: Mechanism, settings: EmulatorSettings) -> None:
        self._simulator = mechanism.simulator()
        self._rate = mechanism.sampling.sampling_rate
        self._block_rate = settings.frame_rate * (1.0 + settings.clock_error)
        self._limit = min(mechanism.actuator.limit, LARGEST * VOLTAGE_UNIT)
        self.faults = LineFaults(settings.seed)
        self._reader = FrameReader()
        self._sequence = self._blocks = 0
        self._began: float | None = None
        self._commanded_at = -math.inf
        self._voltage, self._watchdog, self._stuck_at = 0.0, 0.1, math.nan
        self._is_silent = self.is_streaming = False

    def receive(self, received: bytes, now: float) -> list[bytes]:
        """Take bytes from the computer and return the answers, frame by frame.

        Parameters
        ----------
        received : bytes
            What has come; may begin and end anywhere.
        now : float
            Steady time [s], here and below.
        """
        answers = []
        for frame in self._reader.feed(received):
            if frame.kind == Kind.VOLTAGE:
                voltage = read_voltage(frame.payload)
                if voltage is not None:
                    self._voltage, self._commanded_at, self._is_silent = voltage, now, False
            elif frame.kind in (Kind.STOP, Kind.END):
                self._voltage = 0.0
                self.is_streaming &= frame.kind != Kind.END
            elif frame.kind == Kind.BEGIN:
                answers += self._begin(frame.payload)
            elif frame.kind == FAULT_KIND:
                self._begin_fault(frame.payload, now)
        return [self.faults.spoiled(answer, now) for answer in answers]

    def advance(self, now: float) -> list[bytes]:
        """Let the mechanism run until now, and return the frames with samples that are due."""
        if self._began is None:
            self._began = now
        due = int((now - self._began) * self._block_rate) - self._blocks
        return [message for _ in range(due) for message in self._block(now)]

    def next_block(self) -> float:
        """Return when the next samples are due [s]."""
        return (self._began or 0.0) + (self._blocks + 1) / self._block_rate

    def _begin(self, payload: bytes) -> list[bytes]:
        watchdog = read_begin(payload)
        if watchdog is None:
            return []
        self._voltage, self._watchdog, self.is_streaming = 0.0, watchdog, True
        identity = Identity(PROTOCOL_VERSION, self._rate, self._limit, watchdog)
        return [self._frame(Kind.IDENTITY, identity_payload(identity))]

    def _begin_fault(self, payload: bytes, now: float) -> None:
        name = payload.decode("ascii", errors="replace")
        if name in list(Fault):
            self.faults.begin(Fault(name), now)

    def _block(self, now: float) -> list[bytes]:
        if self._voltage and now - self._commanded_at > self._watchdog:
            self._voltage, self._is_silent = 0.0, True
        first = self._simulator.sample
        rows = self._simulator.advance(self._voltage)[:, 1:]
        self._blocks += 1
        if self.faults.has(Fault.STUCK, now):
            self._stuck_at = rows[0, 1] if math.isnan(self._stuck_at) else self._stuck_at
            rows[:, 1] = self._stuck_at
        else:
            self._stuck_at = math.nan
        if not self.is_streaming:
            return []
        return [
            self.faults.spoiled(self._samples(first + begin, part), now)
            for begin, part in _parts(rows)
        ]

    def _samples(self, first: int, rows: np.ndarray) -> bytes:
        return self._frame(Kind.SAMPLES, samples_payload(Samples(first, self._is_silent, rows)))

    def _frame(self, kind: Kind, payload: bytes) -> bytes:
        self._sequence += 1
        return encoded(Frame(kind, self._sequence, payload))


def _parts(rows: np.ndarray) -> list[tuple[int, np.ndarray]]:
    """Return rows in parts that fit into a frame, each with the number of its first row."""
    return [
        (begin, rows[begin : begin + LARGEST_COUNT]) for begin in range(0, len(rows), LARGEST_COUNT)
    ]
