"""Benchmarks of the program: what it is compared with, and that its failures are told."""

import subprocess
import sys

import pytest

from bdt_study.benchmarks import program
from bdt_study.benchmarks.processes import ProcessError
from bdt_study.benchmarks.result import BenchmarkSize

TINY = BenchmarkSize(loop_duration=1.0)


def test_the_loop_is_compared_with_one_process_and_with_no_recorder(monkeypatch):
    paces = {(): 6.0, ("--processes", "single"): 8.0, ("--no-bag",): 12.0}
    monkeypatch.setattr(program, "loop_factor", lambda _, options: paces[tuple(options)])
    factor, ticks, recorded = program.lockstep_real_time_factor(TINY)
    assert (factor.value, factor.reference_value, factor.ratio) == (6.0, 8.0, 0.75)
    assert (ticks.value, ticks.reference_value, ticks.ratio) == (3000.0, 4000.0, 0.75)
    assert (recorded.value, recorded.reference_value, recorded.ratio) == (3000.0, 6000.0, 0.5)


def test_the_pace_of_the_loop_is_that_of_a_run():
    assert program.loop_factor(1.0, program.SINGLE) > 0


def test_a_loop_that_fails_is_quoted():
    with pytest.raises(ProcessError, match="invalid choice: 'warp'"):
        program.loop_factor(1.0, ["--mode", "warp"])


def test_help_is_timed_beside_python_alone(monkeypatch):
    monkeypatch.setattr(program, "HELPS", 1)
    (result,) = program.bdt_help(TINY)
    assert result.name == "bdt_help"
    assert result.value > result.reference_value > 0


def test_what_is_timed_is_the_help():
    command = [sys.executable, *program.PROGRAM, "--help"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    assert done.stdout.startswith("usage: bdt ")
