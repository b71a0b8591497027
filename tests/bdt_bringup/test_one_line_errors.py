"""Whatever a user asks for: what cannot be is one line and exit code 2, never a traceback."""

import os
import signal
import subprocess
import sys

import pytest

from bdt_bringup.cli import run_command
from bdt_msgs_py.command_errors import BAD_INPUT, INTERRUPTED


@pytest.fixture
def places(tmp_path, small_loop):
    """Return words that stand for paths: a bag, a file in place of a folder, links in a circle."""
    loop = tmp_path / "loop"
    (tmp_path / "pool").symlink_to(loop)
    loop.symlink_to(tmp_path / "pool")
    file = tmp_path / "file"
    file.write_bytes(b"text")
    bag = small_loop.write(tmp_path / "bag")
    return {
        "BAG": bag,
        "LOOP": loop,
        "IN_LOOP": loop / "x",
        "IN_FILE": file / "x",
        "NO_ENDING": tmp_path / "noext",
    }


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["run", "--duration", "1", "--output", "IN_FILE"], "--output"),
        (["run", "--duration", "1", "--output", "/proc/x"], "--output /proc/x: cannot be written"),
        (["run", "--config", "/dev/zero"], "configuration /dev/zero: is a device"),
        (["evaluate", "--figure", "/proc/x.png"], "--figure /proc/x.png: cannot be written"),
        (["evaluate", "--seed", "99999999999999999999"], "--seed 99999999999999999999: must be"),
        (["evaluate", "--seed", "2147483647"], "together at most 2147483648"),
        (["evaluate", "--estimator", "os:getcwd"], "has no method restart()"),
        (["compare", "LOOP", "LOOP"], "Too many levels of symbolic links"),
        (["compare", "BAG", "BAG", "--output", "LOOP"], "cannot be written"),
        (["compare", "BAG", "BAG", "--output", "IN_LOOP"], "cannot be written"),
        (["analyze", "LOOP"], "Too many levels of symbolic links"),
        (["analyze", "BAG", "--output", "LOOP"], "cannot be written"),
        (["analyze", "BAG", "--output", "IN_FILE"], "cannot be written"),
        (["recover", "LOOP"], "does not exist"),
        (["recover", "BAG", "--output", "IN_LOOP"], "cannot be recovered"),
        (["recover", "BAG", "--output", "/proc/x"], "cannot be recovered"),
        (["design", "--output", "NO_ENDING"], "noext: must end with .png, .svg or .pdf"),
        (["design", "--output", "/proc/x.png"], "--output /proc/x.png: cannot be written"),
    ],
)
def test_one_line(places, tmp_path, capsys, monkeypatch, words, reason):
    monkeypatch.chdir(tmp_path)
    assert run_command([str(places.get(word, word)) for word in words]) == BAD_INPUT
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert reason in error
    assert error.count("\n") == 1


def test_a_fit_that_would_leave_the_limits_of_a_constant_is_refused(places, capsys):
    words = ["analyze", str(places["BAG"]), "--estimator", "output_error"]
    settings = ["--set", "structure.stiffness=0.001", "--set", "structure.mass=1e6"]
    assert run_command([*words, *settings]) == BAD_INPUT
    error = capsys.readouterr().err
    assert "structure.stiffness = 0.0005" in error
    assert error.count("\n") == 1


def test_standard_output_on_a_full_disk_is_one_line():
    with open("/dev/full", "wb") as full:  # noqa: PTH123 - a device
        done = subprocess.run(
            [sys.executable, "-m", "bdt_bringup.cli", "config"],
            check=False,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        )
    assert done.stderr == "error: standard output: No space left on device\n"
    assert done.returncode == BAD_INPUT


def test_ctrl_c_that_a_library_turns_into_its_own_error_is_an_interruption(monkeypatch, capsys):
    """While a class is made, Python raises RuntimeError from whatever comes."""

    def interrupted(_options):
        raise RuntimeError("Error calling __set_name__") from KeyboardInterrupt()

    monkeypatch.setattr("bdt_bringup.cli.installed_commands", lambda: {"stop": fake(interrupted)})
    assert run_command(["stop"]) == INTERRUPTED
    assert capsys.readouterr().err == "error: interrupted\n"


def fake(run):
    from bdt_msgs_py.commands import Command

    return Command("stops", "Stops.", lambda _: None, run)


def test_ctrl_c_while_modules_are_imported_leaves_no_traceback(tmp_path):
    """A module that the command imports first sends the signal and waits for it."""
    (tmp_path / "argparse.py").write_text(
        "import os, signal, time\nos.kill(os.getpid(), signal.SIGINT)\ntime.sleep(60)\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "bdt_bringup.program", "config"],
        check=False,
        capture_output=True,
        timeout=50,
        env=os.environ | {"PYTHONPATH": f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}"},
    )
    assert done.returncode in (-signal.SIGINT, 128 + signal.SIGINT)
    assert done.stderr == b""
