"""Pages of loops, for tests that open them in a browser."""

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def report(following_bag: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the report of a loop of 20 s."""
    from bdt_analysis.analyze import analyze

    folder = tmp_path_factory.mktemp("report")
    analyze(following_bag, folder)
    return folder / "report.html"


@pytest.fixture(scope="session")
def comparison(
    following_bag: Path, linear_bag: Path, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    """Return the page that compares two loops."""
    from bdt_analysis.compare import run_comparison

    page = tmp_path_factory.mktemp("comparison") / "page.html"
    run_comparison([following_bag, linear_bag], page, as_json=False)
    return page
