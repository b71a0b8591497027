"""``bdt compare``: numbers, page, errors."""

import json
import re

import pytest

from bdt_analysis.analyze import analyze
from bdt_analysis.figures.plot_series import MOST_POINTS
from bdt_analysis.metrics.compared_runs import load_runs
from bdt_analysis.pages.comparison import (
    all_steps_table,
    compared_series,
    runs_table,
)
from bdt_bringup.cli import run_command
from bdt_msgs_py.topics import REFERENCE


@pytest.fixture(scope="module")
def bags(following_bag, linear_bag):
    return [following_bag, linear_bag]


@pytest.fixture(scope="module")
def runs(bags):
    return load_runs(bags)


def test_page_and_json(bags, tmp_path, capsys):
    page = tmp_path / "new" / "page.html"
    arguments = ["compare", *map(str, bags), "--output", str(page), "--json"]
    assert run_command(arguments) == 0
    printed = json.loads(capsys.readouterr().out)
    for bag, run in zip(bags, printed["runs"], strict=True):
        assert run.pop("bag") == str(bag)
        assert re.match(r"(following|linear)", run.pop("name"))
        assert run == json.loads(json.dumps(analyze(bag).to_dictionary()))
    text = page.read_text(encoding="utf-8")
    assert len(text) < 5_000_000
    assert "://" not in text
    assert "2 runs, 1 of them without a limit cycle" in text


def test_table_of_runs(runs):
    following, linear = ([*row.cells] for row in runs_table(runs).rows)
    names = [column.name for column in runs_table(runs).columns]
    assert int(following[names.index("limit cycles")]) == 0
    assert int(linear[names.index("limit cycles")]) == len(runs[1].summary.limit_cycles) > 0
    first = runs[1].summary.limit_cycles[0]
    assert float(linear[names.index("first at")]) == first.t_start_s
    assert following[names.index("first at")] == ""
    assert [row.alarm for row in runs_table(runs).rows] == [False, True]


def test_table_of_steps_sets_the_runs_below_each_other(runs):
    rows = all_steps_table(runs).rows
    assert [row.step for row in rows] == [1, 1, 2, 2, 3, 3, 4, 4]
    assert rows[0].cells[0] == runs[0].name
    assert rows[1].cells[0] == runs[1].name
    assert rows[7].alarm


def test_a_limit_cycle_has_amplitude_and_frequency(runs):
    for step in runs[1].summary.limit_cycles:
        half = 0.5 * step.residual_peak_to_peak_m
        assert 0.75 * half < step.limit_cycle_amplitude_m <= half
        assert 1.0 < step.limit_cycle_frequency_hz < 3.0
    assert runs[0].summary.steps[0].limit_cycle_frequency_hz is None


def test_each_run_has_one_color_and_one_name_in_the_legend(runs):
    series = compared_series(runs)
    for index, run in enumerate(runs):
        own = [x for x in series if x.run == index and x.name != "reference r"]
        assert {x.color for x in own} == {f"run-{index + 1}"}
        assert [x.name for x in own if not x.quiet] == [run.name]
    assert sum(x.time.size for x in series) <= MOST_POINTS


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ([], "compare: has 1 bag: must have two or more"),
        (["missing"], "does not exist"),
    ],
)
def test_errors_are_one_line(following_bag, tmp_path, capsys, arguments, reason):
    others = [str(tmp_path / name) for name in arguments]
    output = str(tmp_path / "page.html")
    assert run_command(["compare", str(following_bag), *others, "--output", output]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert reason in lines[0]


def test_no_page_in_a_bag_and_none_in_place_of_a_folder(bags, tmp_path, capsys):
    for output in (bags[0] / "page.html", tmp_path):
        assert run_command(["compare", *map(str, bags), "--output", str(output)]) == 2
        assert f"--output {output}" in capsys.readouterr().err


def test_one_loop_of_bags_that_hold_several_is_chosen_as_for_analyze(small_loop, tmp_path, capsys):
    both = small_loop.without()
    both.items.extend((f"/a{name}", *rest) for name, *rest in small_loop.without(REFERENCE).items)
    bags = [str(both.write(tmp_path / name)) for name in ("first", "second")]
    arguments = ["compare", *bags, "--output", str(tmp_path / "page.html"), "--json"]
    assert run_command(arguments) == 2
    assert "choose one with --namespace NAME" in capsys.readouterr().err
    for choice, steps in ((["--namespace", "/"], 2), (["--namespace", "a"], 0)):
        assert run_command([*arguments, *choice]) == 0
        printed = json.loads(capsys.readouterr().out)
        assert [len(run["steps"]) for run in printed["runs"]] == [steps, steps]
    elsewhere = ["--namespace", "a", "--topic", "reference=/reference"]
    assert run_command([*arguments, *elsewhere]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert [len(run["steps"]) for run in printed["runs"]] == [2, 2]
