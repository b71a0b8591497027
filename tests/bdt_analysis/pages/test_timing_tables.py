"""Tables of timing and reconfigurations: the numbers of the summary, and where they are shown."""

import pytest

from bdt_analysis.analyze import analyze
from bdt_analysis.pages.timing_tables import reconfiguration_table, timing_tables
from bdt_bags.reading.recording import load_recording
from bdt_msgs_py.topics import COMMAND, MEASUREMENT, PARAMETER_EVENTS


def columns(table, row=0):
    return dict(zip([column.name for column in table.columns], table.rows[row].cells, strict=True))


@pytest.fixture(scope="module")
def summary(following_bag):
    return analyze(following_bag)


def test_topics_latency_and_delays(summary):
    timing, latency, delays = timing_tables([("run", summary)])
    assert [row.cells[0] for row in timing.rows] == ["measurement", "command", "telemetry"]
    assert float(columns(timing)["period"]) == pytest.approx(2.0)
    assert columns(timing)["gaps"] == "0"
    assert not any(row.alarm for row in timing.rows)
    assert columns(latency)["not answered"] == "0"
    assert float(columns(delays)["largest"]) == pytest.approx(0.52, abs=3e-3)
    assert float(columns(delays)["oldest gap"]) == pytest.approx(0.52, abs=3e-3)


def test_a_gap_stands_out(following_loop, tmp_path):
    messages = following_loop.without()
    messages.items = [
        item for item in messages.items if item[0] != "/command" or not 7.0 < item[2] < 7.1
    ]
    summary = analyze(messages.write(tmp_path / "bag"))
    timing, latency, *_ = timing_tables([("run", summary)])
    assert [row.alarm for row in timing.rows] == [False, True, False]
    assert columns(timing, 1)["gaps"] == "1"
    assert float(columns(timing, 1)["it begins at"]) == pytest.approx(7.0)
    assert int(columns(latency)["not answered"]) > 40


def test_several_runs_are_named(summary):
    for table in timing_tables([("a", summary), ("b", summary)]):
        assert {row.cells[0] for row in table.rows} == {"a", "b"}
        assert all(len(row.cells) == len(table.columns) for row in table.rows)


def test_what_the_bag_lacks_has_no_table(following_loop, tmp_path):
    bare = following_loop.without(MEASUREMENT, COMMAND, PARAMETER_EVENTS)
    bag = bare.write(tmp_path / "bag")
    (timing,) = timing_tables([("run", analyze(bag, tmp_path / "out"))])
    assert [row.cells[0] for row in timing.rows] == ["telemetry"]
    assert reconfiguration_table(load_recording(bag)) is None
    report = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert '<table id="timing">' in report
    assert '<table id="latency">' not in report
    assert "Missing in the bag: no measurement" in report


def test_the_log_has_a_row_for_each_dead_zone(following_bag, summary):
    recording = load_recording(following_bag)
    table = reconfiguration_table(recording)
    assert len(table.rows) == len(recording.dead_zones)
    last = columns(table, -1)
    assert float(last["dead zone ε"]) == pytest.approx(1e6 * summary.dead_zone_final_m, abs=1e-4)
    assert float(last["time"]) - float(last["stated for"]) == pytest.approx(
        float(last["age of the gap"]), abs=2e-4
    )
    assert last["delay"] == last["age of the gap"]
    assert columns(table, 0)["change"] == ""
