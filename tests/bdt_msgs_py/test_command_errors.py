"""Errors that end a program are one line."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bdt_msgs_py.command_errors import BAD_INPUT, BadInputError, complain


@given(st.text())
def test_whatever_a_file_brings_along_a_bad_input_is_one_printable_line(text):
    line = str(BadInputError(text))
    assert len(line.splitlines()) <= 1
    assert all(character.isprintable() for character in line)


def test_words_stay_as_they_are():
    assert str(BadInputError("pid.gain = 'Größe':\n  must be\ta number")) == (
        "pid.gain = 'Größe': must be a number"
    )


@pytest.mark.parametrize("reason", ["two\nlines", ValueError("two\n lines")])
def test_a_complaint_is_one_line_on_standard_error(reason, capsys):
    assert complain(reason, BAD_INPUT) == BAD_INPUT
    out, err = capsys.readouterr()
    assert (out, err) == ("", "error: two lines\n")
