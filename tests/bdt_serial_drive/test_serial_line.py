"""A serial port whose other end takes nothing."""

import os
import time
import tty

import pytest

from bdt_driver.guarded_drive import DriveError
from bdt_serial_drive.serial_drive import SerialDrive
from bdt_serial_drive.serial_line import SerialLine


@pytest.fixture
def hanging_port():
    """Return the name of a port of which nobody reads."""
    device, port = os.openpty()
    tty.setraw(port)
    yield os.ttyname(port)
    os.close(port)
    os.close(device)


def fill(send):
    for _ in range(10_000):
        send()


@pytest.mark.parametrize("patience", [0.01, 0.2])
def test_a_device_that_takes_no_bytes_for_the_time_it_may_take_hangs(hanging_port, patience):
    line = SerialLine(hanging_port, 921600, patience)
    begin = time.monotonic()
    with pytest.raises(DriveError, match=f"takes no bytes for {patience:g} s: the device hangs"):
        fill(lambda: line.send(1, bytes(200)))
    assert time.monotonic() - begin >= patience
    line.close()


def test_a_computer_that_is_busy_is_no_device_that_hangs(hanging_port, monkeypatch):
    """The process stands still for longer than the device may, and the bytes went at once."""
    patience, stand_still = 0.01, 0.03
    send = os.write

    def send_and_stand_still(number, data):
        sent = send(number, data)
        time.sleep(stand_still)
        return sent

    monkeypatch.setattr(os, "write", send_and_stand_still)
    line = SerialLine(hanging_port, 921600, patience)
    for _ in range(3):
        line.send(1, bytes(20))
    line.close()


@pytest.mark.parametrize(("watchdog", "patience"), [(0.01, 0.05), (0.3, 0.3)])
def test_a_drive_is_given_as_long_as_its_watchdog(hanging_port, watchdog, patience):
    drive = SerialDrive(hanging_port, watchdog=watchdog, answer_timeout=0.0)
    with pytest.raises(DriveError, match="no answer"):
        drive.open()
    with pytest.raises(DriveError, match=f"takes no bytes for {patience:g} s"):
        fill(lambda: drive.write(1.0))
    # The port is given back even if the device cannot be told so.
    with pytest.raises(DriveError, match="takes no bytes"):
        drive.close()
    SerialLine(hanging_port, 921600, 1.0).close()
