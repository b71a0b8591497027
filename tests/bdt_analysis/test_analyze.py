"""From the bag to the files, and what the numbers and the report say."""

import json
import re
import sys
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest

from bdt_analysis.analyze import analyze
from bdt_analysis.pages.report import verdict
from bdt_bags.bag_error import BagError
from bdt_bags.reading.recording import load_recording
from bdt_msgs_py.topics import REFERENCE, TRUTH

STEP_KEYS = {
    "t_start_s",
    "reference_m",
    "residual_peak_to_peak_m",
    "bias_m",
    "bias_percent_of_amplitude",
    "settling_time_s",
    "limit_cycle",
    "limit_cycle_amplitude_m",
    "limit_cycle_frequency_hz",
}


@pytest.fixture(scope="module")
def analyzed(following_bag, tmp_path_factory):
    output = tmp_path_factory.mktemp("output") / "new" / "folder"
    return analyze(following_bag, output), output


def not_json(text: str):
    raise AssertionError(text)


def test_summary_file_has_the_agreed_fields(analyzed):
    summary, output = analyzed
    written = json.loads((output / "summary.json").read_text(), parse_constant=not_json)
    assert written == json.loads(json.dumps(summary.to_dictionary()))
    assert set(written) == {
        "duration_s",
        "real_time_factor",
        "steps",
        "estimate",
        "reconfigurations",
        "dead_zone_final_m",
        "messages",
        "lost_messages",
        "lost_in_queue",
        "messages_left_out",
        "missing_samples",
        "missing",
        "holes",
        "timing",
        "reconfiguration_delay",
        "re_estimation",
        "decisions",
    }
    assert written["decisions"] == [], "the twin of this bag does not simulate"
    assert written["re_estimation"] is None, "nobody asked"
    assert set(written["estimate"]) == {
        "rms_error_rad",
        "max_error_rad",
        "worst_lag_s",
        "stated_rms_error_rad",
        "stated_max_error_rad",
        "max_shortfall_rad",
        "voltage_offset_v",
    }
    assert all(set(step) == STEP_KEYS for step in written["steps"])


def test_dead_zone_that_follows_the_gap(analyzed):
    """Delay 0.5 s; update periods end 0.02 s before batches; the gap ends at 30 degrees."""
    summary, _ = analyzed
    assert [step.t_start_s for step in summary.steps] == [0, 5, 10, 15]
    assert not summary.limit_cycles
    assert abs(summary.worst_bias.bias_percent_of_amplitude) < 2
    assert summary.estimate.worst_lag_s == pytest.approx(0.52, abs=3e-3)
    assert summary.estimate.rms_error_rad < np.deg2rad(4)
    assert summary.estimate.max_error_rad >= summary.estimate.rms_error_rad
    assert summary.estimate.stated_max_error_rad <= summary.estimate.max_error_rad
    assert summary.dead_zone_final_m == pytest.approx(7e-5, rel=0.25)
    assert summary.lost_messages == 0
    assert verdict(summary).good


def test_the_verdict_tells_the_error_where_stated_apart_from_the_shortfall(analyzed):
    summary, output = analyzed
    degrees = {
        "stated_max_error_rad": 0.03,
        "stated_rms_error_rad": 0.0072,
        "max_shortfall_rad": 4.03,
        "max_error_rad": 3.99,
    }
    estimate = replace(summary.estimate, **{key: np.deg2rad(x) for key, x in degrees.items()})
    assert (
        "; gap estimates off by 0.030° at worst, 0.007° rms, at the times for which they are "
        "stated, and outgrown by up to 4.03° until the next one came."
    ) in verdict(replace(summary, estimate=estimate)).details
    report = (output / "report.html").read_text(encoding="utf-8")
    assert "gap error where stated, largest" in report
    assert "shortfall until the next estimate, largest" in report


def test_linear_loop_has_limit_cycles(linear_bag):
    summary = analyze(linear_bag)
    assert [step.limit_cycle for step in summary.steps][-2:] == [True, True]
    sizes = [step.residual_peak_to_peak_m for step in summary.steps]
    assert sizes == sorted(sizes)
    assert summary.reconfigurations == 0
    assert summary.dead_zone_final_m == 0.0
    assert summary.estimate.worst_lag_s is None
    assert verdict(summary).headline.startswith("Not stable: limit cycle in ")


def test_report_is_one_file(analyzed):
    _, output = analyzed
    report = (output / "report.html").read_text(encoding="utf-8")
    assert len(report) < 5_000_000
    assert report.count("<svg") == report.count("</svg>") == 2
    assert not re.search(r'(?:src|href)="(?!#)', report)
    assert "http://" not in report.replace("http://www.w3.org/", "")
    assert "https://" not in report
    assert "prefers-color-scheme: dark" in report
    assert "Stable throughout" in report
    identifiers = re.findall(r'\bid="([^"]+)"', report)
    assert len(identifiers) == len(set(identifiers))
    assert (output / "figure.png").read_bytes().startswith(b"\x89PNG")


def test_without_plotly_the_report_has_its_pictures_and_tables(small_loop, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "plotly.offline", None)
    analyze(small_loop.write(tmp_path / "bag"), tmp_path / "out")
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "need the Python package plotly" in report
    assert 'id="signals"' not in report
    assert "<svg" in report
    assert '<table id="steps">' in report


def test_same_bag_gives_the_same_files(analyzed, following_bag, tmp_path):
    _, output = analyzed
    settings = dict(mpl.rcParams)
    analyze(following_bag, tmp_path)
    assert dict(mpl.rcParams) == settings, "matplotlib's settings are global: leave them alone"
    for name in ("summary.json", "report.html", "figure.png"):
        assert (tmp_path / name).read_bytes() == (output / name).read_bytes()


def test_names_are_escaped(small_loop, tmp_path):
    messages = small_loop.without()
    messages.items.append(("/<script>x", *small_loop.items[1][1:]))
    analyze(messages.write(tmp_path / "<b>bag"), tmp_path / "out")
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "<script>x" not in report
    assert "<b>bag" not in report


def test_without_truth(following_loop, tmp_path):
    summary = analyze(following_loop.without(TRUTH).write(tmp_path / "bag"), tmp_path / "out")
    assert summary.estimate.rms_error_rad is None
    assert summary.estimate.worst_lag_s is not None
    assert "gap error unknown" in verdict(summary).details


@pytest.mark.parametrize("end", [0.5, 6.0])
def test_bag_that_ends_early(following_loop, tmp_path, end):
    messages = following_loop.without()
    messages.items = [item for item in messages.items if item[2] <= end]
    summary = analyze(messages.write(tmp_path / "bag"), tmp_path / "out")
    assert summary.steps[-1].limit_cycle is None
    assert summary.lost_messages == 0


def test_other_rates_and_amplitudes(loop_messages, tmp_path):
    messages = loop_messages(
        duration=18.0,
        step_time=9.0,
        amplitude=-2e-3,
        dead_zone=0.0,
        sampling_rate=1000.0,
        control_rate=250.0,
        batch_time=0.4,
    )
    summary = analyze(messages.write(tmp_path / "bag"), tmp_path / "out")
    assert [step.reference_m for step in summary.steps] == [-2e-3, 0.0]
    assert all(step.limit_cycle for step in summary.steps)
    assert summary.duration_s == pytest.approx(18.0)
    assert summary.lost_messages == 0


def test_many_steps_and_no_step(signal_messages, tmp_path):
    time = np.arange(2400) * 0.01
    reference = [(0.1 * k, 1e-3 * np.sin(k)) for k in range(240)]
    messages = signal_messages(time, 1e-3 * np.sin(10 * time), reference)
    assert len(analyze(messages.write(tmp_path / "many"), tmp_path / "a").steps) == 240
    assert "40 more steps" in (tmp_path / "a" / "report.html").read_text(encoding="utf-8")
    late = messages.without(REFERENCE)
    late.reference(100.0, 1e-3)
    summary = analyze(late.write(tmp_path / "none"), tmp_path / "b")
    assert summary.steps == ()
    assert verdict(summary).headline == "No step could be judged"


@pytest.mark.parametrize("place", ["bag", "bag/report"])
def test_output_in_the_bag_is_refused(small_loop, tmp_path, place):
    path = small_loop.write(tmp_path / "bag")
    before = sorted(path.iterdir())
    with pytest.raises(BagError, match="is a bag, which is left as it is"):
        analyze(path, tmp_path / place)
    assert sorted(path.iterdir()) == before


def test_output_that_cannot_be_written(following_bag, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(BagError, match="cannot be written"):
        analyze(following_bag, tmp_path / "file")
    with pytest.raises(BagError, match="cannot be written"):
        analyze(following_bag, tmp_path / "file" / "below")


def test_no_folder_for_a_bad_bag(tmp_path):
    with pytest.raises(BagError):
        analyze(tmp_path / "nothing", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_gap_is_estimated_again(following_bag, tmp_path):
    settings = {"estimator.kind": "output_error", "output_error.window": 5.0}
    summary = analyze(following_bag, tmp_path, settings=settings)
    written = json.loads((tmp_path / "summary.json").read_text(), parse_constant=not_json)
    found = written["re_estimation"]
    assert set(found) == {
        "estimator",
        "settings",
        "recorded_settings",
        "without_effect",
        "sampling_rate_hz",
        "estimates",
        "rms_error_deg",
        "worst_error_deg",
        "coverage_95_percent",
        "kept",
        "kept_reason",
        "rejected",
        "rejected_reason",
        "window_ms",
        "live",
    }
    assert found["settings"] == {"output_error.window": 5.0}
    assert found["live"]["estimates"] == len(load_recording(following_bag).estimates)
    report = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert '<table id="re-estimation">' in report
    assert '"re-estimated (output_error)"' in report, "the curve of the plot"
    assert "re-estimated (output_error)</text>" in report, "the legend of the picture"
    assert "<dt>Re-estimated</dt>" in report
    assert replace(summary, re_estimation=None) == analyze(following_bag)


def test_without_a_re_estimation_the_report_does_not_speak_of_it(analyzed):
    _, output = analyzed
    assert "re-estimat" not in (output / "report.html").read_text(encoding="utf-8").lower()


def test_a_position_that_runs_away_is_not_called_stable(analyzed):
    summary, _ = analyzed
    step = replace(summary.steps[-1], bias_percent_of_amplitude=-250.0, limit_cycle=False)
    result = verdict(replace(summary, steps=(*summary.steps[:-1], step)))
    assert not result.good
    assert "off by more than the step in one step" in result.headline


def test_a_position_that_stays_where_it_was_is_not_called_stable(analyzed):
    summary, _ = analyzed
    step = replace(summary.steps[-1], bias_percent_of_amplitude=-99.9, limit_cycle=False)
    result = verdict(replace(summary, steps=(*summary.steps[:-1], step)))
    assert not result.good
    assert "Stable" not in result.headline
    assert (
        "Not at the reference: the position stays off by more than 5 % of the step in one step, "
        f"first in the one that begins at {step.t_start_s:.6g} s"
    ) == result.headline
