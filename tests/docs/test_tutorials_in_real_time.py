"""Every console block of the tutorials whose loops run in real time."""

import pytest
from typed_tutorials import IN_REAL_TIME, PAGES, run_tutorial

pytestmark = pytest.mark.real_time


@pytest.mark.parametrize(
    "page", [page for page in PAGES if page.stem in IN_REAL_TIME], ids=lambda page: page.stem
)
def test_a_tutorial_prints_what_it_shows(page, folder, environment):
    run_tutorial(page, folder, environment)


def test_there_are_such_tutorials():
    assert {page.stem for page in PAGES} > set(IN_REAL_TIME)
