"""An emulator in a thread of its own, for the tests of this package."""

import threading
from pathlib import Path

import pytest

from bdt_drive_emulator.drive_emulator import DriveEmulator
from bdt_drive_emulator.emulator_settings import EmulatorSettings
from bdt_drive_emulator.mechanism import load_mechanism

WORKSHOP = Path(__file__).parents[2] / "config" / "workshop.yaml"


@pytest.fixture(scope="session")
def workshop():
    """Return the workshop's mechanism."""
    return load_mechanism(WORKSHOP, 1000.0)


@pytest.fixture
def emulate(workshop, tmp_path):
    """Return a function that starts an emulator and returns its port."""
    running = []

    def start(**settings):
        link = tmp_path / f"port{len(running)}"
        emulator = DriveEmulator(workshop, EmulatorSettings(**settings), link)
        ended = threading.Event()
        thread = threading.Thread(target=emulator.run, args=(ended,), daemon=True)
        thread.start()
        running.append((emulator, ended, thread))
        return str(link)

    yield start
    for emulator, ended, thread in running:
        ended.set()
        thread.join()
        emulator.close()
