"""A step of which a part was not recorded, or not controlled, is not judged."""

import json

import numpy as np
import pytest

from bdt_analysis.analyze import analyze
from bdt_analysis.compare import run_comparison
from bdt_analysis.metrics.recording_holes import RecordingHole, hole_lines
from bdt_analysis.pages.report import verdict
from bdt_msgs_py.topics import COMMAND, TELEMETRY, TRUTH


def without(messages, begin, end, *topics):
    """Return the messages but those of some topics, or of all, that came in a stretch of time."""
    names = {topic.name for topic in topics}
    kept = type(messages)(namespace=messages.namespace)
    kept.items = [
        item
        for item in messages.items
        if not (begin < item[2] < end and (not names or item[0].rpartition("/")[2] in names))
    ]
    return kept


def null(step):
    values = (step.residual_peak_to_peak_m, step.bias_m, step.settling_time_s, step.limit_cycle)
    return values == (None,) * 4


def test_a_recorder_that_was_paused_hides_a_step(following_loop, tmp_path):
    """Steps begin at 0, 5, 10 and 15 s; that at 10 s was not recorded."""
    bag = without(following_loop, 7.0, 13.0).write(tmp_path / "bag")
    summary = analyze(bag, tmp_path / "output")
    assert [step.t_start_s for step in summary.steps] == [0, 5, 15]
    assert [null(step) for step in summary.steps] == [False, True, False]
    (hole,) = [hole for hole in summary.holes if hole.topic == TELEMETRY.name]
    assert (hole.begins_s, hole.ends_s) == pytest.approx((7.0, 13.0), abs=0.11)
    assert any(
        line.startswith("no telemetry from t = ") and line.endswith("is not judged")
        for line in summary.missing
    )
    result = verdict(summary)
    assert result.headline == (
        "Stable as far as it was recorded: no limit cycle in 2 steps (1 not judged, "
        "6 s are missing)"
    )
    assert not result.good
    report = (tmp_path / "output" / "report.html").read_text(encoding="utf-8")
    assert result.headline in report
    assert "no telemetry from t = " in report


def test_the_height_of_a_step_behind_a_hole_is_that_from_where_the_platform_was(
    following_loop, tmp_path
):
    """It goes from 5 mm to 0; what was before the hole says nothing of that."""
    whole = analyze(following_loop.write(tmp_path / "whole"), None).steps[-1]
    bag = without(following_loop, 7.0, 13.0).write(tmp_path / "bag")
    behind = analyze(bag, None).steps[-1]
    assert behind.bias_percent_of_amplitude == pytest.approx(
        whole.bias_percent_of_amplitude, rel=0.02
    )
    assert behind.settling_time_s == pytest.approx(whole.settling_time_s, abs=0.01)


def test_a_controller_that_was_paused_is_not_judged(following_loop, tmp_path):
    bag = without(following_loop, 7.0, 8.0, COMMAND).write(tmp_path / "bag")
    summary = analyze(bag, None)
    assert [null(step) for step in summary.steps] == [False, True, False, False]
    assert [hole.topic for hole in summary.holes] == [COMMAND.name]
    assert "no command from t = 7" in " ".join(summary.missing)
    assert not verdict(summary).good


def test_a_controller_that_ended_early_is_not_judged(following_loop, tmp_path):
    bag = without(following_loop, 12.0, 99.0, COMMAND).write(tmp_path / "bag")
    assert [null(step) for step in analyze(bag, None).steps] == [False, False, True, True]


@pytest.mark.parametrize(("first", "judged"), [(0.5, True), (3.5, False)])
def test_a_controller_that_answers_late_is_not_judged(following_loop, tmp_path, first, judged):
    """A recorder that comes later finds one topic after the other."""
    bag = without(following_loop, -1.0, first, COMMAND).write(tmp_path / "bag")
    assert null(analyze(bag, None).steps[0]) is not judged


def test_a_lost_batch_is_a_hole_and_a_lost_sample_or_late_command_none(following_loop, tmp_path):
    batch = without(following_loop, 6.95, 7.05, TELEMETRY, TRUTH).write(tmp_path / "batch")
    assert [null(step) for step in analyze(batch, None).steps] == [False, True, False, False]
    late = without(following_loop, 7.0, 7.05, COMMAND).write(tmp_path / "late")
    summary = analyze(late, None)
    assert summary.holes == ()
    assert verdict(summary).good


def test_a_lost_sample_at_a_low_rate_is_no_hole(signal_messages, tmp_path):
    time = np.delete(np.arange(500) * 0.05, 300)
    bag = signal_messages(time, np.zeros_like(time), [(0.0, 1e-3)]).write(tmp_path / "bag")
    assert analyze(bag, None).holes == ()


def test_many_holes_are_told_in_few_lines():
    holes = [RecordingHole("telemetry", float(k), k + 0.5) for k in range(100)]
    lines = hole_lines(holes)
    assert len(lines) == 6
    assert lines[-1] == "95 more holes of 47.5 s together"


def test_a_comparison_tells_which_runs_have_holes(following_loop, tmp_path, capsys):
    bags = [
        following_loop.write(tmp_path / "whole"),
        without(following_loop, 7.0, 13.0).write(tmp_path / "holes"),
    ]
    run_comparison(bags, tmp_path / "page.html", as_json=True)
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "2 runs, 2 of them without a limit cycle, 1 with holes" in page
    assert len(json.loads(capsys.readouterr().out)["runs"][1]["holes"]) == 2
