"""The driver as a process: what it says and how it ends."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

SUPPORT = Path(__file__).parents[1] / "support"
DEADLINE = 60.0


def start(*parameters, folder):
    """Start a driver in a folder, as ``ros2 run bdt_driver driver_node`` does."""
    options = [part for parameter in parameters for part in ("-p", parameter)]
    command = [sys.executable, "-m", "bdt_driver.driver_node", "--ros-args", *options]
    paths = f"{SUPPORT}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    return subprocess.Popen(
        command,
        cwd=folder,
        env=os.environ | {"PYTHONPATH": paths},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_and_closes_the_drive(tmp_path, number):
    log = tmp_path / "calls"
    driver = start("driver:=rail_drive:RailDrive", f"drive.log:={log}", folder=tmp_path)
    end = time.monotonic() + DEADLINE
    while not (log.exists() and "read" in log.read_text(encoding="utf-8")):
        assert driver.poll() is None, driver.communicate()
        assert time.monotonic() < end
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
    driver = start("driver:=my_drive:MyDrive", folder=tmp_path)
    _, errors = driver.communicate(timeout=DEADLINE)
    assert driver.returncode == 2
    assert errors == (
        "error: parameter driver = 'my_drive:MyDrive': the drive does not open: "
        "my_drive.py:3: OSError: no such port\n"
    )


def test_without_a_drive_it_says_what_to_give(tmp_path):
    driver = start(folder=tmp_path)
    _, errors = driver.communicate(timeout=DEADLINE)
    assert driver.returncode == 2
    assert errors == "error: parameter driver = '': must be module:name of your drive's class\n"
