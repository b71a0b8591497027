"""`bdt evaluate` as a command: options, JSON, figure, and runs that are kept and gone on with."""

import io
import json
import signal
import subprocess
import sys
import time
from dataclasses import replace
from importlib.util import find_spec

import pytest
from rich.console import Console

from bdt_bringup.cli import run_command
from bdt_msgs_py.command_errors import BAD_INPUT, INTERRUPTED
from bdt_study.engine.in_this_process import InThisProcess
from bdt_study.evaluation import evaluate
from bdt_study.evaluation.outcome import CaseOutcome
from bdt_study.evaluation.outcome_table import outcome_tables
from bdt_twin.decision_settings import KINDS as DECISIONS
from bdt_twin.estimator_choice import KINDS

DEADLINE = 120.0

FIELDS = [
    "case",
    "estimator",
    "decision",
    "rms_error_deg",
    "worst_error_deg",
    "coverage_95",
    "crb_ratio",
    "limit_cycle_free_percent",
    "avoidable_limit_cycle_percent",
    "avoidable_steps_percent",
    "spared_steps_percent",
    "bias_under_2_percent",
    "worst_bias_percent",
    "settling_s",
    "taken_back",
    "window_ms",
    "runs",
    "pushed_steps",
    "pushed_limit_cycles",
    "pushed_limit_cycles_with_true_gap",
]


MY_FILE = """
from bdt_twin.estimator import Estimate

class MyEstimator:
    def restart(self):
        self.time = 0.0

    def update(self, batch):
        return Estimate(batch[-1, 0], FOUND)
"""


ARGUMENTS = ["--estimator", "my_file:MyEstimator", "--cases", "clean", "--runs", "1", "--json"]


@pytest.fixture
def in_this_process(monkeypatch):
    """Have no processes started."""
    monkeypatch.setattr(evaluate, "chosen_engine", lambda *_: InThisProcess())


def started(*arguments, folder):
    """Return the command as a process of its own."""
    command = [sys.executable, "-P", "-m", "bdt_bringup.cli", "evaluate", *map(str, arguments)]
    return subprocess.Popen(
        command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def test_the_shortest_class_in_the_current_folder_is_evaluated(tmp_path):
    (tmp_path / "my_file.py").write_text(MY_FILE.replace("FOUND", "0.1"))
    process = started(*ARGUMENTS, folder=tmp_path)
    printed, told = process.communicate(timeout=DEADLINE)
    assert process.returncode == 0, told
    assert "Traceback" not in told
    assert "error" not in told
    (row,) = json.loads(printed)["cases"]
    assert row["estimator"] == "my_file:MyEstimator"


@pytest.mark.parametrize(
    ("found", "says"),
    [
        ("1 / 0", "error: my_file.py:9: ZeroDivisionError: division by zero"),
        ("none", "error: my_file.py:9: NameError: name 'none' is not defined"),
    ],
)
def test_a_class_that_fails_while_it_is_evaluated_is_one_line(
    in_this_process, tmp_path, monkeypatch, capsys, found, says
):
    (tmp_path / "my_file.py").write_text(MY_FILE.replace("FOUND", found))
    monkeypatch.chdir(tmp_path)
    try:
        assert run_command(["evaluate", *ARGUMENTS]) == BAD_INPUT
    finally:
        sys.modules.pop("my_file", None)
    told = capsys.readouterr().err
    assert "Traceback" not in told
    assert [line for line in told.splitlines() if line.startswith("error")] == [says]


def test_the_result_as_json_and_as_a_figure(in_this_process, tmp_path, capsys):
    figure = tmp_path / "new" / "errors.png"
    arguments = ["--cases", "laboratory", "clean", "--runs", "1", "--json", "--figure", str(figure)]
    assert run_command(["evaluate", "--estimator", "inverse_filter", *arguments]) == 0
    rows = json.loads(capsys.readouterr().out)["cases"]
    assert [list(row) for row in rows] == [FIELDS, FIELDS]
    assert [(row["case"], row["estimator"]) for row in rows] == [
        ("laboratory", "inverse_filter"),
        ("clean", "inverse_filter"),
    ]
    assert rows[0]["rms_error_deg"] > 10.0
    assert rows[1]["rms_error_deg"] < 0.5
    assert rows[1]["coverage_95"] is None
    assert figure.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--cases", "moon"], "case 'moon': must be one of clean, laboratory, harsh"),
        (["--estimator", "kalman"], "kind = 'kalman': must be one of inverse_filter, output_error"),
        (["--estimator", "nowhere:E"], "estimator.kind = 'nowhere:E': No module named"),
        (["--runs", "0"], "--runs 0 --seed 0: must be at least 1 and at least 0"),
        (["--seed", "-1"], "--seed -1: must be"),
        (["--workers", "0"], "--workers 0: must be 1 to 1024"),
        (["--workers", "1", "--scheduler", "tcp://127.0.0.1:1"], "a --scheduler has workers of"),
        (["--resume"], "--resume: needs --output, the folder to go on with"),
        (["--figure", "errors.txt"], "--figure errors.txt: must end with .png, .svg or .pdf"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_two(arguments, says, capsys):
    assert run_command(["evaluate", *arguments]) == BAD_INPUT
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert says in error
    assert error.count("\n") == 1


def printed(outcomes):
    """Return what a terminal of 80 columns shows of outcomes, a list of words for each line."""
    console = Console(width=80, file=io.StringIO())
    console.print(*outcome_tables(outcomes))
    return [line.split() for line in console.file.getvalue().splitlines()]


def test_what_is_unknown_is_a_dash_in_the_tables():
    known = (100.0, 0.0, None, None, 50.0, 0.5, None, 0, None, 3)
    row = CaseOutcome("clean", "x:Y", "equation_9", None, None, None, None, *known)
    lines = printed([row])
    assert ["clean", "-", "-", "-", "-", "-"] in lines
    assert ["clean", "100", "-", "-", "50", "0.50", "-"] in lines
    assert lines.count(["x:Y"]) == lines.count(["equation_9"]) == 2


def test_a_terminal_of_80_columns_shows_every_number_with_its_unit():
    numbers = (632187.1, 702294.9, 99.6, 11.9, 100.0, 100.0, 100.0, 100.0, 100.0, 12.34, 12.3)
    rows = [
        CaseOutcome("stiffening_beams", estimator, decision, *numbers, 0, 1234.0, 16)
        for decision in DECISIONS
        for estimator in KINDS
    ]
    lines = printed(rows)
    for words in (
        ["stiffening_beams", "6.3e+05", "7e+05", "100", "11.9", "1234"],
        ["stiffening_beams", "100", "100.0", "100", "100", "12.34", "12.3"],
    ):
        assert lines.count(words) == len(rows)
    shown = [word for line in lines for word in line]
    assert shown.count("[deg]") == 2
    assert {"avoidable", "settling", "[%]", "[s]", "[ms]"} <= set(shown)


def test_steps_that_were_pushed_stand_below_the_table():
    numbers = (1.0, 2.0, 95.0, None, 100.0, 0.0, 0.0, 100.0, 100.0, 0.5, 3.0, 0, 50.0, 16)
    row = CaseOutcome("pushes", "output_error", "equation_9", *numbers)
    assert not any("pushed" in line for line in printed([row]))
    lines = printed([row, replace(row, pushed_steps=9, pushed_limit_cycles=2)])
    told = " ".join(word for line in lines for word in line)
    assert told.endswith(
        "without 9 steps that something pushed while they were judged; 2 of them look like a limit "
        "cycle, with the true gap 0"
    )


def test_a_figure_has_cases_that_decide_in_different_ways(in_this_process, tmp_path, capsys):
    figure = tmp_path / "errors.svg"
    arguments = ["--cases", "clean", "everyday", "--runs", "1", "--json", "--figure", str(figure)]
    assert run_command(["evaluate", *arguments, "--estimator", "inverse_filter"]) == 0
    cases = json.loads(capsys.readouterr().out)["cases"]
    assert [case["decision"] for case in cases] == ["equation_9", "simulate"]
    assert "everyday" in figure.read_text(encoding="utf-8")


def test_both_ways_to_decide_are_compared_on_the_same_scenarios(in_this_process, capsys):
    arguments = ["--cases", "clean", "--runs", "1", "--json", "--estimator", "inverse_filter"]
    decisions = ["--decision", "equation_9", "--decision", "simulate"]
    assert run_command(["evaluate", *arguments, *decisions]) == 0
    by_rule, simulated = json.loads(capsys.readouterr().out)["cases"]
    assert [by_rule["decision"], simulated["decision"]] == ["equation_9", "simulate"]
    assert simulated["worst_bias_percent"] < by_rule["worst_bias_percent"]
    assert simulated["limit_cycle_free_percent"] == 100.0


FEW = ["--estimator", "inverse_filter", "--cases", "clean", "laboratory"]
kept = pytest.mark.skipif(find_spec("pyarrow") is None, reason="beside a ROS 2 without pyarrow")


@pytest.fixture
def rows(capsys):
    """Return a function that runs the command and returns its rows without processor times."""

    def run(*arguments):
        assert run_command(["evaluate", *FEW, "--json", *map(str, arguments)]) == 0
        told = json.loads(capsys.readouterr().out)["cases"]
        return [{name: row[name] for name in FIELDS if name != "window_ms"} for row in told]

    return run


def parts(folder):
    return {path.name: path.read_bytes() for path in folder.glob("runs/*.parquet")}


@kept
def test_killed_and_resumed_the_table_is_the_same_and_no_finished_run_is_lost(
    in_this_process, rows, tmp_path
):
    output = tmp_path / "kept"
    runs = ["--runs", 6]
    process = started(*FEW, *runs, "--output", output, "--workers", 1, folder=tmp_path)
    end = time.monotonic() + DEADLINE
    while not parts(output):
        assert time.monotonic() < end
        assert process.poll() is None
        time.sleep(0.002)
    process.kill()
    process.communicate(timeout=DEADLINE)
    there = parts(output)
    assert 0 < len(there) < 12
    assert rows(*runs, "--output", output, "--resume") == rows(*runs)
    assert parts(output).items() >= there.items()


@pytest.mark.skipif(find_spec("distributed") is None, reason="beside a ROS 2 without Dask")
def test_the_workers_of_a_scheduler_find_the_same(rows, cluster):
    address, _, start_worker = cluster
    start_worker()
    assert rows("--runs", 2, "--scheduler", address) == rows("--runs", 2, "--workers", 1)


@kept
def test_more_runs_go_on_where_fewer_ended_and_fewer_are_still_known(
    in_this_process, rows, tmp_path
):
    one = rows("--runs", 1, "--output", tmp_path / "kept")
    there = parts(tmp_path / "kept")
    two = rows("--runs", 2, "--output", tmp_path / "kept", "--resume")
    assert two == rows("--runs", 2)
    assert parts(tmp_path / "kept").items() >= there.items()
    assert rows("--runs", 1, "--output", tmp_path / "kept", "--resume") == one


@kept
def test_ctrl_c_keeps_what_is_finished_and_tells_how_to_go_on(monkeypatch, tmp_path, capsys):
    class Interrupted(InThisProcess):
        """An engine that is interrupted at its first job."""

        def results(self, jobs):
            for number, result in super().results(jobs):
                signal.raise_signal(signal.SIGINT)
                yield number, result

    monkeypatch.setattr(evaluate, "chosen_engine", lambda *_: Interrupted())
    output = tmp_path / "kept"
    assert run_command(["evaluate", *FEW, "--runs", "2", "--output", str(output)]) == INTERRUPTED
    told = capsys.readouterr().err.splitlines()[-1]
    assert told == (
        f"error: interrupted: 1 of 4 runs are in {output}; to go on: the same command with --resume"
    )
    assert list(parts(output)) == ["part-0000000.parquet"]


@kept
def test_a_folder_of_another_evaluation_is_refused(in_this_process, rows, tmp_path, capsys):
    arguments = ["--runs", "1", "--output", str(tmp_path / "kept")]
    rows(*arguments)
    for more, says in (
        ([], "already holds this evaluation: go on with --resume"),
        (["--resume", "--seed", "1"], "another evaluation or version, which differs in seed"),
        (["--resume", "--cases", "harsh"], "which differs in cases"),
    ):
        assert run_command(["evaluate", *FEW, *arguments, *more]) == BAD_INPUT
        told = capsys.readouterr().err
        assert says in told
        assert told.count("\n") == 1
