"""The README says what the code says."""

from pathlib import Path

from bdt_bringup.running.interface_tables import all_tables

README = Path(__file__).parents[1] / "README.md"


def test_the_tables_of_topics_and_parameters_are_those_of_the_code():
    assert all_tables() in README.read_text(encoding="utf-8")
