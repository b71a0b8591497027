"""A pseudo-terminal as a serial port with a cable."""

import os
import time

import pytest

from bdt_drive_emulator.pseudo_terminal import PseudoTerminal

DEADLINE = 10.0


@pytest.fixture
def terminal(tmp_path):
    made = PseudoTerminal(tmp_path / "port")
    yield made
    made.pull()


def read(terminal, count):
    received, end = b"", time.monotonic() + DEADLINE
    while len(received) < count:
        assert time.monotonic() < end
        terminal.wait(0.1)
        received += terminal.read()
    return received


def test_bytes_go_both_ways_as_they_are(terminal, tmp_path):
    everything = bytes(range(256))
    port = os.open(tmp_path / "port", os.O_RDWR | os.O_NOCTTY)
    os.write(port, everything)
    assert read(terminal, 256) == everything
    terminal.write(everything)
    assert os.read(port, 1000) == everything
    os.close(port)


def test_without_anybody_who_reads_bytes_are_lost_and_nothing_waits(terminal):
    for _ in range(1000):
        terminal.write(bytes(1000))


def test_a_pulled_cable_takes_the_port_away_and_it_comes_back_by_the_same_name(terminal, tmp_path):
    port = os.open(tmp_path / "port", os.O_RDWR | os.O_NOCTTY)
    terminal.pull()
    with pytest.raises(OSError, match="Input/output error"):
        os.write(port, b"x")
    os.close(port)
    assert not (tmp_path / "port").is_symlink()
    assert (terminal.read(), terminal.is_plugged_in) == (b"", False)
    terminal.write(b"nobody")
    terminal.wait(0.0)
    terminal.plug_in()
    port = os.open(tmp_path / "port", os.O_RDWR | os.O_NOCTTY)
    terminal.write(b"again")
    assert os.read(port, 10) == b"again"
    os.close(port)
