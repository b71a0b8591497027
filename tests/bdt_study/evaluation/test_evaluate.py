"""`bdt evaluate` as a command: options, JSON, figure."""

import json
import subprocess
import sys

import pytest

from bdt_bringup.cli import run_command
from bdt_msgs_py.command_errors import BAD_INPUT
from bdt_study.evaluation.evaluate import outcome_table
from bdt_study.evaluation.outcome import CaseOutcome

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
    "bias_under_2_percent",
    "worst_bias_percent",
    "settling_s",
    "taken_back",
    "window_ms",
    "runs",
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


def test_the_shortest_class_in_the_current_folder_is_evaluated(tmp_path):
    (tmp_path / "my_file.py").write_text(MY_FILE.replace("FOUND", "0.1"))
    command = [sys.executable, "-P", "-m", "bdt_bringup.cli", "evaluate", *ARGUMENTS]
    done = subprocess.run(command, cwd=tmp_path, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    assert "error" not in done.stderr
    (row,) = json.loads(done.stdout)["cases"]
    assert row["estimator"] == "my_file:MyEstimator"


@pytest.mark.parametrize(
    ("found", "says"),
    [
        ("1 / 0", "error: my_file.py:9: ZeroDivisionError: division by zero"),
        ("none", "error: my_file.py:9: NameError: name 'none' is not defined"),
    ],
)
def test_a_class_that_fails_while_it_is_evaluated_is_one_line(
    tmp_path, monkeypatch, capsys, found, says
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


def test_the_result_as_json_and_as_a_figure(tmp_path, capsys):
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
        (["--figure", "errors.txt"], "--figure errors.txt: must end with .png, .svg or .pdf"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_two(arguments, says, capsys):
    assert run_command(["evaluate", *arguments]) == BAD_INPUT
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert says in error
    assert error.count("\n") == 1


def test_what_is_unknown_is_a_dash_in_the_table():
    told = ("clean", "x:Y", "equation_9")
    row = CaseOutcome(*told, None, None, None, None, 100.0, 0.0, None, 50.0, 0.5, None, 0, None, 3)
    cells = [list(column.cells) for column in outcome_table([row]).columns]
    numbers = [["-"]] * 4 + [["100"], ["0"], ["50"], ["0.50"], ["-"], ["-"]]
    assert cells == [[each] for each in told] + numbers


def test_both_ways_to_decide_are_compared_on_the_same_scenarios(capsys):
    arguments = ["--cases", "clean", "--runs", "1", "--json", "--estimator", "inverse_filter"]
    decisions = ["--decision", "equation_9", "--decision", "simulate"]
    assert run_command(["evaluate", *arguments, *decisions]) == 0
    by_rule, simulated = json.loads(capsys.readouterr().out)["cases"]
    assert [by_rule["decision"], simulated["decision"]] == ["equation_9", "simulate"]
    assert simulated["worst_bias_percent"] < by_rule["worst_bias_percent"]
    assert simulated["limit_cycle_free_percent"] == 100.0
