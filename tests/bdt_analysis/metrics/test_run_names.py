"""Names that tell runs apart."""

from pathlib import Path

import pytest

from bdt_analysis.metrics.run_names import run_names


@pytest.mark.parametrize(
    ("bags", "names"),
    [
        (["/runs/paper/bag"], ["paper"]),
        (["/runs/paper/bag", "/runs/linear/bag"], ["paper", "linear"]),
        (["/data/monday.mcap", "/data/tuesday.mcap"], ["monday.mcap", "tuesday.mcap"]),
        (["/a/run/bag", "/b/run/bag"], ["a/run", "b/run"]),
        (["/a/run/bag", "/b/run/bag", "/b/other/bag"], ["a/run", "b/run", "b/other"]),
        (["/runs/x/bag", "/runs/x/bag"], ["x (1)", "x (2)"]),
    ],
)
def test_the_shortest_end_that_differs(bags, names):
    assert run_names([Path(bag) for bag in bags]) == names
