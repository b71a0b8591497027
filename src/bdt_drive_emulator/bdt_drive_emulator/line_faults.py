"""What goes wrong between a device and a computer, on demand and for a while."""

import random
from enum import StrEnum

FAULT_TIME = 0.3
"""Time [s] for which a fault lasts."""
AFFECTED = 10
"""One frame in so many is torn, doubled, lost or garbled while such a fault lasts."""


class Fault(StrEnum):
    """Faults that an emulated device can be told to have."""

    TORN = "torn"
    DOUBLED = "doubled"
    LOST = "lost"
    GARBLED = "garbled"
    NOISE = "noise"
    SILENT = "silent"
    STUCK = "stuck"
    PULLED = "pulled"


class LineFaults:
    """Spoils frames on their way to the computer.

    Parameters
    ----------
    seed : int
        Which frames, and how.
    """

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)  # noqa: S311 - nothing secret
        self._until: dict[Fault, float] = {}

    def begin(self, fault: Fault, now: float) -> None:
        """Have a fault from now on [s], for :data:`FAULT_TIME`."""
        self._until[fault] = now + FAULT_TIME

    def has(self, fault: Fault, now: float) -> bool:
        """Tell whether a fault lasts."""
        return now < self._until.get(fault, now)

    def spoiled(self, frame: bytes, now: float) -> bytes:
        """Return what arrives of a frame."""
        if not self._until:
            return frame
        if self.has(Fault.SILENT, now) or self._strikes(Fault.LOST, now):
            return b""
        if self._strikes(Fault.TORN, now):
            frame = frame[: self._random.randrange(1, len(frame))]
        if self._strikes(Fault.GARBLED, now):
            garbled = bytearray(frame)
            garbled[self._random.randrange(len(frame))] ^= 1 << self._random.randrange(8)
            frame = bytes(garbled)
        if self._strikes(Fault.NOISE, now):
            frame = self._random.randbytes(self._random.randrange(1, 40)) + frame
        return frame * 2 if self._strikes(Fault.DOUBLED, now) else frame

    def _strikes(self, fault: Fault, now: float) -> bool:
        return self.has(fault, now) and self._random.randrange(AFFECTED) == 0
