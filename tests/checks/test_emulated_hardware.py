"""`make hardware`: what it makes of a run, and that it ends what it started."""

import json

import pytest

from bdt_serial_drive.serial_drive import SerialDrive
from checks.emulated_hardware import (
    CONFIGURATION,
    PORT_IN_CONFIGURATION,
    TIMEOUT_IN_CONFIGURATION,
    emulator,
    run_faults,
)


def summary(folder, *, duration=60.0, unanswered=0):
    latency = {"median_s": 0.0004, "p99_s": 0.001, "unanswered": unanswered}
    content = {
        "duration_s": duration,
        "messages": {"/measurement": 30000},
        "timing": {"latency": latency},
        "reconfigurations": 5,
    }
    (folder / "summary.json").write_text(json.dumps(content), encoding="utf-8")


def test_a_whole_run_is_well_and_is_told_in_a_line(tmp_path, capsys):
    summary(tmp_path)
    assert run_faults(tmp_path, 60.0) == []
    assert capsys.readouterr().out == (
        "loop: 30000 measurements in 60.0 s, answered after 0.40 ms (median) and 1.00 ms (99 %); "
        "5 reconfigurations\n"
    )


def test_a_short_run_or_one_without_answers_is_not(tmp_path):
    summary(tmp_path, duration=30.0, unanswered=1000)
    assert run_faults(tmp_path, 60.0) == [
        "the bag has 30.0 s of 60 s",
        "1000 measurements have no answer",
    ]


def test_the_emulator_ends_with_what_needs_it(tmp_path):
    port = tmp_path / "port"
    with emulator(port):
        drive = SerialDrive(str(port))
        drive.open()
        drive.close()
    assert not port.is_symlink()


def test_the_emulator_ends_when_what_needs_it_fails(tmp_path):
    with pytest.raises(ZeroDivisionError), emulator(tmp_path / "port"):
        raise ZeroDivisionError
    assert not (tmp_path / "port").is_symlink()


def test_what_is_replaced_stands_in_the_configuration():
    text = CONFIGURATION.read_text(encoding="utf-8")
    assert text.count(PORT_IN_CONFIGURATION) == 1
    assert text.count(TIMEOUT_IN_CONFIGURATION) == 2
