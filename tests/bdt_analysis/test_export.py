"""Exports: the same numbers in files of other tools."""

import csv
import os
import subprocess
import sys

import numpy as np
import pytest

from bdt_analysis.analyze import analyze
from bdt_analysis.export import FORMATS, checked_formats, signal_tables
from bdt_bags.bag_error import BagError
from bdt_bags.reading.recording import load_recording
from bdt_bringup.cli import run_command
from bdt_msgs_py.topics import TRUTH

SIGNALS = {
    "telemetry",
    "truth",
    "reference",
    "estimates",
    "dead_zones",
    "reconfigurations",
    "steps",
}


@pytest.fixture(scope="module")
def exported(following_bag, tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    summary = analyze(following_bag, folder, formats=FORMATS)
    return load_recording(following_bag), summary, folder / "export"


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    return head, rows


def test_every_figure_and_every_signal_is_there(exported):
    _, _, folder = exported
    names = {path.name for path in folder.iterdir()}
    pictures = {f"{name}.{kind}" for name in ("overview", "residuals") for kind in ("png", "svg")}
    tables = {f"{name}.{kind}" for name in SIGNALS for kind in ("csv", "parquet")}
    assert names == pictures | tables
    assert (folder / "overview.png").read_bytes().startswith(b"\x89PNG")
    svg = (folder / "overview.svg").read_text(encoding="utf-8")
    assert "<svg" in svg
    assert "var(--" not in svg, "an SVG file has no page that defines colors"


def test_csv_gives_the_same_floats_again(exported):
    recording, _, folder = exported
    head, rows = rows_of(folder / "telemetry.csv")
    assert head == ["t[s]", "u[V]", "q3[m]"]
    np.testing.assert_array_equal(np.array(rows, dtype=float), recording.telemetry)


def test_parquet_gives_the_same_floats_again(exported):
    parquet = pytest.importorskip("pyarrow.parquet")
    recording, _, folder = exported
    table = parquet.read_table(folder / "truth.parquet")
    assert table.column_names[3] == "gap[rad]"
    np.testing.assert_array_equal(
        np.stack([column.to_numpy() for column in table.columns], axis=1), recording.truth
    )
    steps = parquet.read_table(folder / "steps.parquet").to_pylist()
    assert [step["limit_cycle"] for step in steps] == [False] * 4


def test_steps_have_the_names_of_the_summary(exported):
    _, summary, folder = exported
    head, rows = rows_of(folder / "steps.csv")
    assert head[:3] == ["t_start_s", "reference_m", "residual_peak_to_peak_m"]
    assert [float(row[2]) for row in rows] == [s.residual_peak_to_peak_m for s in summary.steps]
    assert rows[0][head.index("limit_cycle_frequency_hz")] == ""


def test_times_are_those_of_the_bag(following_bag, exported):
    """Also where the clock counts from 1970 and the analysis subtracts whole seconds."""
    recording, summary, _ = exported
    from dataclasses import replace

    later = replace(recording, time_origin=1.7e9)
    tables = {table.name: table for table in signal_tables(later, summary.steps)}
    for name in SIGNALS:
        assert min(tables[name].data[0]) >= 1.7e9


def test_estimates_of_the_recorded_telemetry_are_a_table(following_bag, exported, tmp_path):
    assert not (exported[2] / "re_estimates.csv").exists(), "nobody asked"
    settings = {"estimator.kind": "inverse_filter"}
    analyze(following_bag, tmp_path, formats=("csv",), settings=settings)
    head, rows = rows_of(tmp_path / "export" / "re_estimates.csv")
    assert head == ["t[s]", "gap[rad]", "standard_uncertainty[rad]", "error[rad]"]
    recording, (time, gap, uncertainty, error) = exported[0], np.array(rows, dtype=float).T
    np.testing.assert_allclose(time, recording.estimates[:, 0], atol=1e-9)
    np.testing.assert_array_equal(gap, recording.estimates[:, 1])
    assert np.isnan(uncertainty).all()
    np.testing.assert_allclose(gap - error, np.deg2rad(30.0) * time / 20.0, atol=1e-12)


def test_without_truth_there_is_no_table_of_it(small_loop, tmp_path):
    bag = small_loop.without(TRUTH).write(tmp_path / "bag")
    analyze(bag, tmp_path / "out", formats=("csv",))
    assert not (tmp_path / "out" / "export" / "truth.csv").exists()
    assert (tmp_path / "out" / "export" / "telemetry.csv").exists()


@pytest.mark.parametrize("names", ["xls", "png,xls", "", "PNG"])
def test_unknown_formats_are_named_before_anything_is_read(names, tmp_path, capsys):
    assert run_command(["analyze", str(tmp_path / "nothing"), "--export", names]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert "must be of png, svg, csv, parquet" in lines[0]


def test_formats_are_taken_once_and_in_order():
    assert checked_formats("csv, png,csv") == ("csv", "png")


@pytest.mark.parametrize(
    ("file", "text", "says"),
    [
        (
            "numpy_too_old/pyarrow/__init__.py",
            "raise ImportError('pyarrow requires NumPy 2.0 or newer, found 1.26.4')",
            "pyarrow requires NumPy 2.0 or newer, found 1.26.4",
        ),
        ("half/pyarrow/__init__.py", "", "No module named 'pyarrow.parquet'"),
        ("broken/pyarrow/__init__.py", "raise AttributeError('_ARRAY_API')", "_ARRAY_API"),
    ],
)
def test_a_pyarrow_that_does_not_work_is_one_line_before_anything_is_read(
    tmp_path, file, text, says
):
    module = tmp_path / file
    module.parent.mkdir(parents=True)
    module.write_text(text)
    code, err = export_in_a_process(tmp_path, module.parents[1])
    assert code == 2
    assert err == f"error: --export parquet: needs the Python package pyarrow: {says}\n"


def test_parquet_without_pyarrow_is_one_line_and_the_rest_works(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(BagError, match="parquet: needs the Python package pyarrow: "):
        checked_formats("parquet")
    assert checked_formats("csv") == ("csv",)


def export_in_a_process(folder, path):
    command = [sys.executable, "-m", "bdt_bringup.cli", "analyze", str(folder / "no_bag")]
    paths = [str(path), os.environ.get("PYTHONPATH", "")]
    done = subprocess.run(
        [*command, "--export", "parquet"],
        check=False,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))},
    )
    return done.returncode, done.stderr
