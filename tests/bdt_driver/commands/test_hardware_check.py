"""``bdt hardware-check``: what it asks for, prints and returns."""

import json

import checked_drives
import pytest
from checked_drives import Machine, Rail

from bdt_bringup.cli import run_command
from bdt_driver.commands.hardware_check import parameters_given
from bdt_driver.hardware_check import steady_clock
from bdt_driver.hardware_check.runner import CHECKS

LIMITS = ["limits.voltage:=2.0", "limits.lowest_position:=-0.005", "limits.highest_position:=0.005"]
FAST = ["sampling_rate:=1000.0", "command_timeout:=0.02"]


def check(capsys, monkeypatch, name, *options, parameters=(*FAST, *LIMITS)):
    """Run the command in the time of the rail; return exit code, output and errors."""
    Machine.rail = Rail()
    monkeypatch.setattr(steady_clock, "ComputerClock", lambda: Machine.rail.clock)
    given = [word for parameter in parameters for word in ("-p", parameter)]
    code = run_command(["hardware-check", f"checked_drives:{name}", *given, *options])
    return code, *capsys.readouterr()


def test_a_good_drive_gets_a_line_for_each_check_and_0(capsys, monkeypatch):
    code, output, errors = check(capsys, monkeypatch, "GoodDrive", "--yes")
    lines = output.splitlines()
    assert (code, errors) == (0, "")
    assert [line.split()[1] for line in lines[:-1]] == [check.name for check in CHECKS]
    assert lines[-1] == f"{len(CHECKS)} ok, 0 failed, 0 skipped"


def test_a_drive_that_fails_gets_1_and_is_told_what_to_do(capsys, monkeypatch):
    code, output, _ = check(capsys, monkeypatch, "HasSign", "--yes")
    assert code == 1
    assert "failed    has_sign                   2 V move the platform by -5" in output
    assert "do:  Swap the motor's wires" in output


def test_json_is_all_there_is_on_standard_output(capsys, monkeypatch):
    code, output, _ = check(capsys, monkeypatch, "GoodDrive", "--json")
    assert code == 0
    assert len(json.loads(output)["checks"]) == len(CHECKS)


def test_without_limits_consent_is_not_enough(capsys, monkeypatch):
    code, _, errors = check(capsys, monkeypatch, "GoodDrive", "--yes", parameters=FAST)
    assert code == 2
    assert errors == "error: --yes: needs the limits of the motion: -p limits.voltage:=...\n"


@pytest.mark.parametrize(
    ("parameter", "line"),
    [
        ("port", "-p port: must be NAME:=VALUE"),
        ("drive.port:={", "-p drive.port:={: is not YAML"),
        ("control_rte:=500.0", "control_rte = 500.0: is not a parameter of this node; did you"),
        ("control_rate:=500", "control_rate = 500: must be written with a decimal point"),
        ("engage_time:=0.01", "engage_time = 0.01 s: must be at least 100 control periods"),
    ],
)
def test_a_parameter_that_is_none_is_one_line(capsys, monkeypatch, parameter, line):
    code, _, errors = check(capsys, monkeypatch, "GoodDrive", parameters=[parameter])
    assert code == 2
    assert line in errors
    assert errors.count("\n") == 1


def test_arguments_of_the_class_keep_their_types():
    assert parameters_given(["drive.port:=/dev/x", "drive.number:=3", "drive.gain:=2.0"]) == {
        "drive.port": "/dev/x",
        "drive.number": 3,
        "drive.gain": 2.0,
    }


def test_a_drive_that_does_not_end_is_told(capsys, monkeypatch):
    class Stubborn(checked_drives.GoodDrive):
        def close(self):
            super().close()
            if self.reads > 1000:
                raise OSError("cannot close")

    monkeypatch.setattr(checked_drives, "Stubborn", Stubborn, raising=False)
    code, _, errors = check(capsys, monkeypatch, "Stubborn")
    assert code == 1
    assert "the drive does not end: " in errors
    assert "OSError: cannot close" in errors
