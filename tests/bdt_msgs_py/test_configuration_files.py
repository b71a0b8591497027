"""Configurations are found by name, wherever they are installed, or as files."""

import pytest

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.configuration_files import find_configuration, packaged_configurations


def test_a_configuration_is_found_by_its_name_from_any_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert find_configuration("paper") == packaged_configurations()["paper"]
    assert find_configuration(None) is None


def test_a_name_that_is_neither_is_one_line_with_those_that_there_are():
    with pytest.raises(BadInputError, match="must be one of fixed_dead_zone, laboratory, linear"):
        find_configuration("papper")
    with pytest.raises(BadInputError, match="did you mean paper"):
        find_configuration("papper")
