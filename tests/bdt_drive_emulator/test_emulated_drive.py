"""A serial drive and the emulator at the two ends of a pseudo-terminal, in real time."""

import math
import time

import pytest

from bdt_drive_emulator.emulated_drive import EmulatedDrive
from bdt_driver.guarded_drive import DriveError

pytestmark = pytest.mark.real_time

DEADLINE = 30.0


@pytest.fixture
def drive(emulate):
    made = EmulatedDrive(emulate(), watchdog=0.05)
    made.open()
    yield made
    made.stop()
    made.close()


def read_until(drive, condition):
    """Read until a reading meets the condition; return all of them."""
    end = time.monotonic() + DEADLINE
    readings = [drive.read()]
    while not condition(readings[-1]):
        assert time.monotonic() < end
        time.sleep(0.001)
        readings.append(drive.read())
    return readings


def opens(drive):
    """Return whether the drive opens; what it says otherwise must be that there is no port."""
    try:
        drive.open()
    except DriveError as error:
        return "there is no such port" not in str(error)
    return True


def read_samples(drive, count):
    passed = 0

    def have_passed(reading):
        nonlocal passed
        passed += len(reading.samples) + reading.lost
        return passed >= count

    return read_until(drive, have_passed)


def test_it_tells_the_rate_of_the_mechanism(drive):
    assert drive.identity.sampling_rate == 5000.0


def test_the_platform_moves_with_the_voltage_and_rests_without(drive):
    begin = drive.read().position
    end = time.monotonic() + DEADLINE
    while (reading := drive.read()).position < begin + 0.001:
        assert time.monotonic() < end
        # As often as it is heard of, or a busy computer's emulator does not follow.
        if len(reading.samples):
            drive.write(4.0)
    drive.stop()
    read_until(drive, lambda reading: len(reading.samples) and not reading.samples[-1, 0])


def test_the_device_s_watchdog_takes_the_voltage_off(drive):
    drive.write(1.0)
    read_until(drive, lambda reading: reading.voltage == 1.0)
    read_until(drive, lambda reading: reading.voltage == 0.0)


def test_jitter_loses_no_sample(emulate):
    drive = EmulatedDrive(emulate(jitter=0.005))
    drive.open()
    assert not any(reading.lost for reading in read_samples(drive, 2000))
    drive.close()


@pytest.mark.parametrize("fault", ["torn", "doubled", "lost", "garbled", "noise", "silent"])
def test_it_survives_what_happens_on_a_line(drive, fault):
    read_samples(drive, 10)
    drive.fault(fault)
    readings = read_samples(drive, 3000)
    assert all(math.isfinite(reading.position) for reading in readings)
    assert all(abs(reading.position) < 1e-4 for reading in readings)
    lost = sum(reading.lost for reading in readings)
    assert (lost > 0) == (fault not in ("doubled", "noise"))


def test_a_pulled_cable_is_told_and_the_port_comes_back(drive):
    drive.fault("pulled")
    with pytest.raises(DriveError, match="the device is gone: is the cable in"):
        read_until(drive, lambda reading: False)
    with pytest.raises(DriveError):
        drive.close()
    end = time.monotonic() + DEADLINE
    while not opens(drive):
        assert time.monotonic() < end
        time.sleep(0.01)
    assert math.isfinite(drive.read().position)


def test_a_fault_that_there_is_not_is_refused(drive):
    with pytest.raises(ValueError, match="'rust' is not a valid Fault"):
        drive.fault("rust")
