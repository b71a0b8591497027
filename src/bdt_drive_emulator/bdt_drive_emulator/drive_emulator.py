"""The emulator: an emulated device behind a pseudo-terminal, in real time."""

import random
import threading
import time
from collections import deque
from pathlib import Path

from bdt_drive_emulator.emulated_device import EmulatedDevice
from bdt_drive_emulator.emulator_settings import EmulatorSettings
from bdt_drive_emulator.line_faults import Fault
from bdt_drive_emulator.mechanism import Mechanism
from bdt_drive_emulator.pseudo_terminal import PseudoTerminal


class DriveEmulator:
    """A device on a serial port that is none.

    Parameters
    ----------
    mechanism : Mechanism
        What it drives.
    settings : EmulatorSettings
        Its clock, and its transport.
    link : Path or None
        Symbolic link to the port.
    """

    def __init__(
        self, mechanism: Mechanism, settings: EmulatorSettings, link: Path | None = None
    ) -> None:
        self._device = EmulatedDevice(mechanism, settings)
        self._jitter = settings.jitter
        self._random = random.Random(settings.seed)  # noqa: S311 - nothing secret
        self._terminal = PseudoTerminal(link)
        self._on_the_way: deque[tuple[float, bytes]] = deque()

    @property
    def port(self) -> str:
        """Name of the port."""
        return self._terminal.name

    @property
    def device(self) -> EmulatedDevice:
        """The device."""
        return self._device

    def run(self, ended: threading.Event) -> None:
        """Run until the event is set."""
        while not ended.is_set():
            self.turn()
            self._terminal.wait(self._next_turn() - time.monotonic())

    def turn(self) -> None:
        """Do what is due."""
        now = time.monotonic()
        self._plug(now)
        answers = self._device.receive(self._terminal.read(), now)
        for frame in (*answers, *self._device.advance(now)):
            delay = self._jitter and self._random.uniform(0.0, self._jitter)
            self._on_the_way.append((now + delay, frame))
        while self._on_the_way and self._on_the_way[0][0] <= now:
            self._terminal.write(self._on_the_way.popleft()[1])

    def close(self) -> None:
        """Take the port away."""
        self._terminal.pull()

    def _next_turn(self) -> float:
        due = self._on_the_way[0][0] if self._on_the_way else self._device.next_block()
        return min(due, self._device.next_block())

    def _plug(self, now: float) -> None:
        is_pulled = self._device.faults.has(Fault.PULLED, now)
        if is_pulled and self._terminal.is_plugged_in:
            self._terminal.pull()
            self._on_the_way.clear()
        elif not is_pulled and not self._terminal.is_plugged_in:
            self._terminal.plug_in()
