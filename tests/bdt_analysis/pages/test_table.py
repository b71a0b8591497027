"""Numbers in tables are what a spreadsheet reads."""

import pytest

from bdt_analysis.pages.table import number


@pytest.mark.parametrize(
    ("value", "form", "scale", "text"),
    [
        (1.25e-6, ".2f", 1e6, "1.25"),
        (-0.5, ".1f", 1.0, "-0.5"),
        (-1e-9, ".3f", 1.0, "0.000"),
        (0.0, ".3g", 1.0, "0"),
        (-100.0, ".0f", 1.0, "-100"),
        (None, ".3f", 1.0, ""),
    ],
)
def test_plain_with_an_ascii_sign_and_none_on_zero(value, form, scale, text):
    assert number(value, form, scale) == text
