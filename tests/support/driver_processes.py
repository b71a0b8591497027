"""Drivers as processes, for tests."""

import os
import subprocess
import sys
import time
from pathlib import Path

DEADLINE = 60.0
"""Wall time [s] after which a driver will not read any more."""


def start_driver(*parameters, folder, module="bdt_driver.driver_node", arguments=()):
    """Start a driver in a folder, as ``ros2 run`` does; it finds the drives of this one."""
    options = [part for parameter in parameters for part in ("-p", parameter)]
    paths = f"{Path(__file__).parent}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    return subprocess.Popen(
        [sys.executable, "-m", module, "--ros-args", *options, *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": paths},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def wait_until_read(driver, log):
    """Wait until a drive that notes its calls in a file has been read."""
    end = time.monotonic() + DEADLINE
    while not (log.exists() and "read" in log.read_text(encoding="utf-8")):
        assert driver.poll() is None, driver.communicate()
        assert time.monotonic() < end
        time.sleep(0.02)
