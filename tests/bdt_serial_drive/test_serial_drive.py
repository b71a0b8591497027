"""A serial drive at the other end of a pseudo-terminal whose device is a script of the test."""

import os
import select
import threading
import time
import tty
from contextlib import suppress

import numpy as np
import pytest

from bdt_driver.guarded_drive import DriveError
from bdt_serial_drive.frames import Frame, FrameReader, encoded
from bdt_serial_drive.messages import (
    Identity,
    Kind,
    Samples,
    identity_payload,
    read_begin,
    read_voltage,
    samples_payload,
)
from bdt_serial_drive.serial_drive import SerialDrive

DEADLINE = 30.0


class Device:
    """Answers ``BEGIN`` in a thread of its own; a test sends and looks at what has come."""

    def __init__(self, version=1, *, answers=True):
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)
        self.frames, self._version, self._answers = [], version, answers
        self._reader = FrameReader()
        self._woken, self._wake = os.pipe()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self):
        while self._woken not in select.select([self._master, self._woken], [], [])[0]:
            for frame in self._reader.feed(os.read(self._master, 4096)):
                self.frames.append(frame)
                if frame.kind == Kind.BEGIN and self._answers:
                    self.send(Kind.IDENTITY, identity_payload(self.identity(frame)))
                    self.samples(100, 1)

    def identity(self, frame):
        return Identity(self._version, 5000.0, 24.0, read_begin(frame.payload))

    def send(self, kind, payload):
        os.write(self._master, encoded(Frame(kind, 0, payload)))

    def samples(self, first, count, position=0.001):
        rows = np.column_stack((np.full(count, 2.0), position + 1e-6 * np.arange(count)))
        self.send(Kind.SAMPLES, samples_payload(Samples(first, False, rows)))

    def noise(self, content):
        os.write(self._master, content)

    def wait_for(self, kind, count=1):
        end = time.monotonic() + DEADLINE
        while len(found := [frame for frame in self.frames if frame.kind == kind]) < count:
            assert time.monotonic() < end, f"no {kind!r}"
        return found

    def pull(self):
        if self._thread.is_alive():
            os.write(self._wake, b"\0")
            self._thread.join()
            for end in (self._slave, self._master, self._wake, self._woken):
                os.close(end)


@pytest.fixture
def device():
    made = Device()
    yield made
    made.pull()


@pytest.fixture
def drive(device):
    made = SerialDrive(device.port, watchdog=0.25)
    made.open()
    yield made
    with suppress(DriveError):  # a test may have pulled the cable
        made.close()


def reading_of(drive, count):
    """Read until so many samples have come or are lost."""
    end = time.monotonic() + DEADLINE
    readings, passed = [], 0
    while passed < count:
        assert time.monotonic() < end
        readings.append(drive.read())
        passed += len(readings[-1].samples) + readings[-1].lost
    return readings


def test_opening_tells_the_device_its_watchdog_and_learns_who_it_is(device, drive):
    (begin,) = device.wait_for(Kind.BEGIN)
    assert read_begin(begin.payload) == 0.25
    assert drive.identity == pytest.approx(Identity(1, 5000.0, 24.0, 0.25))


def test_a_reading_has_the_samples_since_the_one_before(device, drive):
    assert len(drive.read().samples) == 1
    device.samples(101, 5)
    device.samples(106, 5)
    readings = reading_of(drive, 10)
    rows = np.concatenate([reading.samples for reading in readings])
    assert rows[:, 0] == pytest.approx(np.full(10, 2.0))
    assert rows[:5, 1] == pytest.approx(0.001 + 1e-6 * np.arange(5))
    assert readings[-1][:2] == pytest.approx((0.001004, 2.0))
    empty = drive.read()
    assert empty.samples.shape == (0, 2)
    assert empty[:2] == pytest.approx((0.001004, 2.0))


def test_samples_behind_a_hole_come_with_the_next_reading(device, drive):
    drive.read()
    device.samples(101, 5)
    device.samples(116, 5)
    device.samples(121, 5)
    readings = [reading for reading in reading_of(drive, 25) if len(reading.samples)]
    assert sum(reading.lost for reading in readings) == 10
    assert readings[0].lost == 0
    assert sum(len(reading.samples) for reading in readings) == 15


def test_torn_and_doubled_frames_and_noise_cost_nothing_but_themselves(device, drive):
    drive.read()
    whole = encoded(Frame(Kind.SAMPLES, 0, samples_payload(Samples(101, False, np.ones((5, 2))))))
    device.noise(b"\xb5\x62\xb5" + whole + whole[:20] + whole)
    device.samples(106, 30)
    device.samples(136, 30)
    readings = reading_of(drive, 65)
    assert sum(len(reading.samples) for reading in readings) == 65
    assert not any(reading.lost for reading in readings)


def test_a_voltage_gets_on_the_line(device, drive):
    drive.write(-3.5)
    (frame,) = device.wait_for(Kind.VOLTAGE)
    assert read_voltage(frame.payload) == -3.5


def test_what_is_no_voltage_does_not(device, drive):
    with pytest.raises(ValueError, match="voltage = nan V: must be a number"):
        drive.write(float("nan"))


def test_a_second_thread_stops_while_the_first_one_reads(device, drive):
    ended = threading.Event()

    def read():
        while not ended.is_set():
            drive.read()

    reader = threading.Thread(target=read)
    reader.start()
    drive.stop()
    device.wait_for(Kind.STOP, 2)
    ended.set()
    reader.join()


def test_it_opens_again_after_it_was_closed_twice(device, drive):
    drive.close()
    drive.close()
    device.wait_for(Kind.END)
    drive.open()
    assert drive.read().position == pytest.approx(0.001)


def test_before_it_is_open_it_stops_and_closes_and_nothing_else(device):
    drive = SerialDrive(device.port)
    drive.stop()
    drive.close()
    for call in (drive.read, lambda: drive.write(0.0)):
        with pytest.raises(DriveError, match=r"^port /dev/pts/\d+: is not open$"):
            call()


def test_a_cable_that_is_pulled_is_one_line(device, drive):
    device.pull()
    line = r"^port /dev/pts/\d+: the device is gone: is the cable in\?$"
    for call in (drive.read, lambda: drive.write(0.0), drive.stop, drive.close):
        with pytest.raises(DriveError, match=line):
            call()


def test_a_port_that_is_missing_or_busy_or_no_port_is_one_line(tmp_path, device, drive):
    with pytest.raises(DriveError, match=r"x: there is no such port: is the cable in, and the"):
        SerialDrive(str(tmp_path / "x")).open()
    with pytest.raises(DriveError, match=r": busy: another program has opened it$"):
        SerialDrive(device.port).open()
    file = tmp_path / "file"
    file.write_text("", encoding="utf-8")
    with pytest.raises(DriveError, match=r"file: .*Inappropriate ioctl"):
        SerialDrive(str(file)).open()


def test_a_device_that_does_not_answer_is_asked_again_and_then_told():
    device = Device(answers=False)
    drive = SerialDrive(device.port, answer_timeout=0.35)
    try:
        with pytest.raises(DriveError, match=r"no answer for 0\.35 s: is it the right device"):
            drive.open()
        device.wait_for(Kind.BEGIN, 3)
    finally:
        drive.close()
        device.pull()


def test_a_device_of_another_version_is_refused():
    device = Device(version=2)
    drive = SerialDrive(device.port)
    try:
        with pytest.raises(DriveError, match="speaks version 2 of the protocol: must be 1"):
            drive.open()
    finally:
        drive.close()
        device.pull()


@pytest.mark.parametrize("watchdog", [0.0, 100.0, float("nan")])
def test_a_watchdog_that_is_none_is_refused(watchdog):
    with pytest.raises(DriveError, match=r"drive\.watchdog = .* s: must be 0\.001 to 60 s"):
        SerialDrive("x", watchdog=watchdog)
