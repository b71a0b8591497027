"""The driver as a process: what it says and how it ends."""

import signal

import pytest
from driver_processes import DEADLINE, start_driver, wait_until_read


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_and_closes_the_drive(tmp_path, number):
    log = tmp_path / "calls"
    driver = start_driver("driver:=rail_drive:RailDrive", f"drive.log:={log}", folder=tmp_path)
    wait_until_read(driver, log)
    driver.send_signal(number)
    output, errors = driver.communicate(timeout=DEADLINE)
    assert (driver.returncode, output, errors) == (0, "", "")
    assert log.read_text(encoding="utf-8").split() == ["open", "read", "stop", "close"]


def test_a_drive_in_the_current_folder_is_found_and_what_fails_in_it_is_told(tmp_path):
    (tmp_path / "my_drive.py").write_text(
        "class MyDrive:\n"
        "    def open(self):\n"
        "        raise OSError('no such port')\n"
        "    def read(self): ...\n"
        "    def write(self, voltage): ...\n"
        "    def stop(self): ...\n"
        "    def close(self): ...\n",
        encoding="utf-8",
    )
    driver = start_driver("driver:=my_drive:MyDrive", folder=tmp_path)
    _, errors = driver.communicate(timeout=DEADLINE)
    assert driver.returncode == 2
    assert errors == (
        "error: parameter driver = 'my_drive:MyDrive': the drive does not open: "
        "my_drive.py:3: OSError: no such port\n"
    )


def test_without_a_drive_it_says_what_to_give(tmp_path):
    driver = start_driver(folder=tmp_path)
    _, errors = driver.communicate(timeout=DEADLINE)
    assert driver.returncode == 2
    assert errors == "error: parameter driver = '': must be module:name of your drive's class\n"
