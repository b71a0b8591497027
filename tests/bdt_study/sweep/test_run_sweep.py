"""`bdt sweep` as a command: the same bytes whoever works on them and whatever ends it."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bdt_bringup.cli import run_command
from bdt_msgs_py.command_errors import BAD_INPUT, FAILED, INTERRUPTED
from bdt_study.engine.in_this_process import InThisProcess
from bdt_study.engine.part_folder import PARTS
from bdt_study.sweep import batches as batches_module
from bdt_study.sweep import run_sweep
from bdt_study.sweep.data_set import DataSet

DEADLINE = 120.0

PROGRAM = """
import sys
from bdt_study.sweep import batches
batches.MOST_RUNS = int(sys.argv.pop(1))
from bdt_bringup.cli import main
main(sys.argv[1:])
"""


pytestmark = pytest.mark.usefixtures("small_batches")


def started(*arguments):
    """Return the command as a process of its own."""
    size = str(batches_module.MOST_RUNS)
    command = [sys.executable, "-P", "-c", PROGRAM, size, "sweep", *map(str, arguments)]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def wait_for(condition):
    end = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def workers_of(process):
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    return [int(child) for child in children]


def test_interrupted_killed_and_resumed_the_bytes_are_the_same(undisturbed, bytes_of, tmp_path):
    study, expected = undisturbed
    output = tmp_path / "sweep"
    parts = output / PARTS

    def count():
        return len(list(parts.glob("*.parquet"))) if parts.is_dir() else 0

    process = started(study, "--output", output, "--workers", 1)
    wait_for(count)
    process.send_signal(signal.SIGINT)
    _, told = process.communicate(timeout=DEADLINE)
    assert process.returncode == INTERRUPTED, told
    last = told.splitlines()[-1]
    assert last.startswith("error: interrupted: ")
    assert f"bdt sweep {study} --output {output} --resume" in last
    interrupted_at = count()
    assert 0 < interrupted_at < len(expected)
    assert not list(parts.glob("*.unfinished"))

    process = started(study, "--output", output, "--workers", 1, "--resume")
    wait_for(lambda: count() > interrupted_at)
    workers = workers_of(process)
    process.kill()
    process.communicate(timeout=DEADLINE)
    assert workers
    wait_for(lambda: not any(Path(f"/proc/{worker}").exists() for worker in workers))
    assert interrupted_at < count() < len(expected)

    arguments = ["sweep", str(study), "--output", str(output), "--workers", "1"]
    assert run_command([*arguments, "--resume"]) == 0
    assert bytes_of(output) == expected
    assert len(list((output / "sessions").iterdir())) == 3


@pytest.fixture
def in_this_process(monkeypatch):
    monkeypatch.setattr(run_sweep, "chosen_engine", lambda *_: InThisProcess())


def test_the_outcome_as_json_has_the_first_answers(in_this_process, study_file, tmp_path, capsys):
    output = tmp_path / "sweep"
    assert run_command(["sweep", str(study_file()), "--output", str(output), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["runs"], told["runs_now"], told["runs_missing"]) == (48, 48, 0)
    assert told["now"]["limit_cycle"]["known"] == 48
    session = json.loads(next((output / "sessions").iterdir()).read_text())
    assert session["cores"] == os.cpu_count()
    assert {"machine", "numpy", "python"} <= session.keys()


def test_another_ctrl_c_does_not_wait_for_what_is_in_work(
    study_file, tmp_path, monkeypatch, capsys
):
    class Endless(InThisProcess):
        """An engine whose work never ends, in which somebody presses Ctrl-C twice."""

        def results(self, jobs):
            yield next(super().results(jobs))
            for _ in range(2):
                signal.raise_signal(signal.SIGINT)
            pytest.fail("waited")

    monkeypatch.setattr(run_sweep, "chosen_engine", lambda *_: Endless())
    output = tmp_path / "sweep"
    assert run_command(["sweep", str(study_file()), "--output", str(output)]) == INTERRUPTED
    assert "Traceback" not in capsys.readouterr().err
    assert len(list((output / PARTS).iterdir())) == 1


def test_a_disk_that_fills_ends_it_with_what_there_is(
    in_this_process, study_file, tmp_path, capsys, monkeypatch
):
    written = []

    def write(data, number, result):
        if len(written) == 3:
            raise OSError(28, "No space left on device")
        written.append(result)

    monkeypatch.setattr(DataSet, "write", write)
    arguments = ["sweep", str(study_file()), "--output", str(tmp_path / "sweep")]
    assert run_command(arguments) == FAILED
    told = capsys.readouterr().err
    assert "cannot be written: No space left on device; what is there is whole" in told


def test_a_dry_run_writes_nothing_and_says_how_large_it_gets(study_file, tmp_path, capsys):
    arguments = ["sweep", str(study_file()), "--dry-run", "--output", str(tmp_path / "no")]
    assert run_command(arguments) == 0
    assert capsys.readouterr().out.startswith("48 runs in 12 parts: about ")
    assert run_command([*arguments, "--json", "--workers", "4"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["seconds"] == pytest.approx(48 * told["seconds_per_run"] / 4)
    assert told["bytes"] > 1000
    assert not (tmp_path / "no").exists()


@pytest.mark.parametrize("more", [[], ["--dry-run"]])
def test_a_number_of_workers_that_makes_no_sense_is_refused(study_file, capsys, more):
    assert run_command(["sweep", str(study_file()), "--workers", "0", *more]) == BAD_INPUT
    assert "--workers 0: must be 1 to 1024" in capsys.readouterr().err
