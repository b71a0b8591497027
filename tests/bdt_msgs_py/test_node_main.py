"""A node as a process: one-line errors, exit codes, signals."""

import os
import signal
import subprocess
import sys

import pytest

DEADLINE = 30.0
MODULES = {
    "plant": "bdt_plant.plant_node",
    "controller": "bdt_controller.controller_node",
    "twin": "bdt_twin.twin_node",
}


def node(name, *arguments):
    return subprocess.Popen(
        [sys.executable, "-m", MODULES[name], "--ros-args", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )


@pytest.mark.parametrize("name", MODULES)
def test_an_unknown_parameter_is_one_line_and_exit_code_two(name):
    process = node(name, "-p", "no_such:=1.0")
    out, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 2
    assert err == f"error: parameter no_such = 1.0: is not a parameter of /{name}\n"
    assert out == ""


@pytest.mark.parametrize("value", ["-1.0", ".nan", "5", "wide", "[1.0]"])
def test_a_value_that_is_not_allowed_is_one_line_and_exit_code_two(value):
    process = node("controller", "-p", f"dead_zone_tolerance:={value}")
    _, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 2
    assert err.startswith("error: parameter dead_zone_tolerance = ")
    assert "0 to 0.1 m" in err
    assert err.count("\n") == 1


def test_a_parameter_file_that_is_missing_is_named(tmp_path):
    process = node("controller", "--params-file", str(tmp_path / "none.yaml"))
    _, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 2
    assert "none.yaml" in err
    assert "Traceback" not in err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_node_without_complaint(number):
    process = node("plant", "-p", "resend_period:=0.05")
    line = process.stderr.readline()
    assert "waiting for a command" in line
    process.send_signal(number)
    _, err = process.communicate(timeout=DEADLINE)
    assert process.returncode == 0
    assert "Traceback" not in err


def test_a_plant_whose_controller_is_gone_ends_with_exit_code_one():
    plant = node("plant", "-p", "resend_period:=0.05", "-p", "lockstep_timeout:=0.3")
    controller = node("controller")
    # The plant runs once the controller is there; then the controller is taken away.
    assert "waiting" in plant.stderr.readline()
    try:
        plant.wait(timeout=1.0)
    except subprocess.TimeoutExpired:
        controller.kill()
    controller.communicate(timeout=DEADLINE)
    _, err = plant.communicate(timeout=DEADLINE)
    assert plant.returncode == 1
    assert "error: /plant waited" in err
    assert "for a command" in err
