"""`bdt run` with the driver of an emulated machine in place of the plant."""

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

pytestmark = pytest.mark.real_time

CONFIG = Path(__file__).parents[2] / "config"
DEADLINE = 180.0
BDT = (sys.executable, "-m", "bdt_bringup.program")


@pytest.fixture
def machine(tmp_path):
    """Return a configuration, and the emulator that it is for."""
    link = tmp_path / "port"
    command = [*BDT, "drive-emulator", "--link", str(link)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as emulator:
        emulator.stdout.readline()
        text = (CONFIG / "serial_drive.yaml").read_text(encoding="utf-8")
        document = yaml.safe_load(text)
        driver = document["/**/driver"]["ros__parameters"]
        # A computer that is busy with other tests may let everybody wait.
        driver["drive"] = {"port": str(link), "watchdog": 5.0, "answer_timeout": 30.0}
        driver["command_timeout"] = 5.0
        file = tmp_path / "machine.yaml"
        file.write_text(yaml.safe_dump(document), encoding="utf-8")
        yield file, emulator
        emulator.terminate()


@pytest.mark.parametrize("processes", ["separate", "shared"])
def test_a_run_arms_the_machine_records_it_and_ends(processes, machine, tmp_path):
    output = tmp_path / "run"
    options = ["--config", machine[0], "--duration", "5", "--output", output, "--json"]
    options += ["--processes", processes]
    command = [*BDT, "run", *map(str, options)]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=DEADLINE)
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["duration_s"] == pytest.approx(5.0, abs=3.0)  # a busy one disarms late
    assert summary["messages"]["/command"] > 500
    said = (output / "log" / "driver.log").read_text(encoding="utf-8")
    assert "the drive is armed" in said
    assert "the drive is open" in said
    assert (output / "log" / "controller.log").exists() == (processes == "separate")


def test_a_device_that_is_gone_ends_the_run_with_one_line(machine, tmp_path):
    file, emulator = machine
    output = tmp_path / "run"
    options = ["--config", str(file), "--duration", "1000", "--output", str(output), "--no-bag"]
    with subprocess.Popen([*BDT, "run", *options], stderr=subprocess.PIPE, text=True) as run:
        log = output / "log" / "driver.log"
        end = time.monotonic() + DEADLINE
        while not (log.exists() and "is armed" in log.read_text(encoding="utf-8")):
            assert run.poll() is None, run.stderr.read()
            assert time.monotonic() < end
            time.sleep(0.05)
        emulator.kill()
        _, errors = run.communicate(timeout=DEADLINE)
    assert run.returncode == 1
    assert "error: node driver: the drive is stopped: port " in errors
    assert "the device is gone: is the cable in?" in errors
