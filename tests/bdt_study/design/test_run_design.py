"""`bdt design` prints what design_pid finds and draws it."""

import json

import pytest

from bdt_bringup.cli import run_command
from bdt_controller.pid import PidGains
from bdt_study.design import run_design as command


def test_the_printed_gains_are_the_shipped_ones_and_meet_the_demands_of_the_paper(tmp_path, capsys):
    picture = tmp_path / "design.png"
    assert run_command(["design", "--output", str(picture), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    shipped = PidGains()
    assert printed["gains"]["proportional"] == pytest.approx(shipped.proportional, rel=1e-3)
    assert printed["gains"]["filter_time"] == pytest.approx(shipped.filter_time, rel=1e-2)
    for loop in ("continuous", "sampled"):
        assert printed[loop]["stable"]
        assert printed[loop]["smallest_phase_margin_deg"] >= 10.0
    assert printed["continuous"]["first_gain_crossover_rad_s"] == pytest.approx(10.0, rel=1e-3)
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.fixture
def designed(design, monkeypatch):
    """Give the command its design at once: what becomes of it is tested."""
    monkeypatch.setattr(command, "design_pid", lambda _: design)


@pytest.mark.usefixtures("designed")
def test_without_json_there_are_tables(tmp_path, capsys):
    picture = tmp_path / "design.png"
    assert run_command(["design", "--output", str(picture)]) == 0
    out = capsys.readouterr().out
    assert "K_p" in out
    assert "smallest_phase_margin_deg" in out


@pytest.mark.usefixtures("designed")
def test_a_picture_that_cannot_be_written_is_one_line_and_exit_code_two(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert run_command(["design", "--output", str(tmp_path / "file" / "design.png")]) == 2
    err = capsys.readouterr().err
    assert err.startswith("error: --output ")
    assert err.count("\n") == 1
