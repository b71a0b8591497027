"""Tables of the pages: plain numbers, so that a spreadsheet takes them as they are."""

from collections.abc import Sequence
from dataclasses import dataclass

UNKNOWN = ""
"""Text of an unknown value: a blank cell is no number in a spreadsheet either."""


@dataclass(frozen=True)
class Column:
    """Head of a column.

    Attributes
    ----------
    name, unit : str
        Quantity and unit; the unit is empty for pure numbers.
    text : bool
        True for words, which stand at the left.
    """

    name: str
    unit: str = ""
    text: bool = False


@dataclass(frozen=True)
class Row:
    """One row.

    Attributes
    ----------
    cells : sequence of str
        One text for each column.
    alarm : bool
        True to make the row stand out.
    step : int, optional
        Number of the step to which a click on the row leads the plots.
    """

    cells: Sequence[str]
    alarm: bool = False
    step: int | None = None


@dataclass(frozen=True)
class Table:
    """A table of a page.

    Attributes
    ----------
    key : str
        Its id on the page.
    title : str
        Heading.
    columns : sequence of Column
        Heads.
    rows : sequence of Row
        Rows.
    note : str
        Sentence below it.
    empty : str
        What stands in place of the rows when there are none.
    """

    key: str
    title: str
    columns: Sequence[Column]
    rows: Sequence[Row]
    note: str = ""
    empty: str = "Nothing."


def number(value: float | None, form: str, scale: float = 1.0) -> str:
    """Return a number as text, with an ASCII minus sign; blank when it is unknown.

    What rounds to zero has no sign.

    Parameters
    ----------
    value : float or None
        The number.
    form : str
        Format specification.
    scale : float
        Factor from the unit of `value` to that of the column.
    """
    if value is None:
        return UNKNOWN
    text = format(value * scale, form)
    return text.removeprefix("-") if not text.strip("-0.") else text
