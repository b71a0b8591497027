"""``bdt reproduce``: all claims, figures and the page, with fewer values of the other choices."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from bdt_bringup.cli import run_command
from bdt_study.engine.in_this_process import InThisProcess
from bdt_study.reproduction.claim_robustness import open_choices
from bdt_study.reproduction.reproduce import run_reproduction
from bdt_study.reproduction.sweep_settings import SweepSettings

PAPER_FIGURES = ("figure_2.png", "figure_3.png", "figure_4.png", "figure_6.png", "figure_7.png")
FEWER = SweepSettings(
    delays=(0.0, 1.0, 30.0),
    dead_zone_ratios=(0.0, 1.0, 4.0),
    choices=tuple(replace(choice, values=choice.values[-1:]) for choice in open_choices()),
    gaps=tuple(np.deg2rad([2.5, 30.0]).tolist()),
    stiffness_factors=(0.8, 60.0),
    decision_gaps=(28.0,),
)
"""All random delays, on which a claim rests, and the ends of what is only drawn."""


@pytest.fixture(scope="module")
def output(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reproduction") / "new"
    assert run_reproduction(InThisProcess(), folder, FEWER, as_json=True) == 0
    return folder


def test_all_claims_hold(output):
    claims = json.loads((output / "claims.json").read_text(encoding="utf-8"))
    assert [claim["id"] for claim in claims if not claim["holds"]] == []
    assert len({claim["id"] for claim in claims}) == len(claims) >= 12
    for claim in claims:
        assert set(claim) == {"id", "paper_says", "measured", "unit", "holds"}
        assert isinstance(claim["measured"], float)


def test_claims_come_in_the_order_of_the_figures(output):
    claims = json.loads((output / "claims.json").read_text(encoding="utf-8"))
    figures = [claim["id"].split("_")[0] for claim in claims]
    assert figures == sorted(figures)
    assert set(figures) == {"decision", "design", "fig2", "fig3", "fig4", "fig6", "fig7"}


def test_the_figures_of_the_paper_are_there(output):
    for name in PAPER_FIGURES:
        assert (output / name).read_bytes().startswith(b"\x89PNG")


def test_the_page_shows_every_figure_and_needs_nothing_else(output):
    page = (output / "index.html").read_text(encoding="utf-8")
    shown = re.findall(r'src="([^"]+)"', page)
    assert sorted(shown) == sorted(path.name for path in output.glob("*.png"))
    assert set(PAPER_FIGURES) <= set(shown)
    assert "://" not in page


def test_the_page_states_what_the_paper_leaves_open(output):
    page = (output / "index.html").read_text(encoding="utf-8")
    assert "gap 30° · (t / 120 s)²" in page
    assert page.count("Open in the paper.") >= 5
    assert "does not hold for" in page


def test_json_prints_the_claims(output, capsys, monkeypatch):
    """With the simulations already done: printing is what is tested."""
    from bdt_study.reproduction import reproduce as command

    claims = json.loads((output / "claims.json").read_text(encoding="utf-8"))
    failing = command.Claim("fig7_x", "It is so.", 1.0, "m", holds=False, meaning="made up")
    nothing = command.Reproduction((failing,), {}, (), (), ())
    sizes = []
    monkeypatch.setattr(command, "reproduce", lambda *given: sizes.append(given[2]) or nothing)
    assert run_command(["reproduce", "--output", str(output), "--json"]) == 1
    printed = capsys.readouterr()
    assert json.loads(printed.out) == [failing.to_dictionary()]
    assert printed.err.splitlines()[-1] == "error: 1 claims do not hold"
    assert claims != json.loads(printed.out)
    assert len(sizes[0].choices) == len(FEWER.choices)
    assert all(len(choice.values) >= 4 for choice in sizes[0].choices)
    assert len(sizes[0].stiffness_factors) == 14


@pytest.mark.parametrize(
    ("arguments", "says"),
    [(["--output", "file"], "--output file: "), (["--workers", "0"], "--workers 0: ")],
)
def test_bad_input_is_one_line_and_exit_code_2(arguments, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    assert run_command(["reproduce", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"error: {says}")
    assert len(error.splitlines()) == 1
