"""The emulator as a process: its port, its end, its one-line errors."""

import signal
import subprocess
import sys

import pytest

from bdt_bringup.cli import run_command
from bdt_serial_drive.serial_drive import SerialDrive

DEADLINE = 60.0


def start(*arguments):
    command = [sys.executable, "-m", "bdt_bringup.program", "drive-emulator", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_serves_a_port_until_a_signal_and_takes_the_link_away(tmp_path, number):
    link = tmp_path / "port"
    process = start("--link", str(link))
    assert process.stdout.readline() == f"port: {link}\n"
    drive = SerialDrive(str(link))
    drive.open()
    drive.close()
    process.send_signal(number)
    assert process.communicate(timeout=DEADLINE) == ("", "")
    assert process.returncode == 0
    assert not link.is_symlink()


def test_an_old_link_is_no_obstacle(tmp_path):
    link = tmp_path / "port"
    link.symlink_to(tmp_path / "gone")
    process = start("--link", str(link), "--config", "paper")
    assert process.stdout.readline() == f"port: {link}\n"
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=DEADLINE)
    assert process.returncode == 0


def test_a_file_is_not_replaced_by_a_link(tmp_path, capsys):
    file = tmp_path / "notes"
    file.write_text("mine", encoding="utf-8")
    assert run_command(["drive-emulator", "--link", str(file)]) == 2
    assert file.read_text(encoding="utf-8") == "mine"
    assert "exists already and is no link" in capsys.readouterr().err


def test_a_configuration_that_there_is_not_is_one_line(capsys):
    assert run_command(["drive-emulator", "--config", "workshp"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: --config workshp: is no file, and no packaged configuration")
    assert error.count("\n") == 1
