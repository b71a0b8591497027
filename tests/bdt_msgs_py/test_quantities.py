"""What a described quantity accepts and how it words a refusal."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from bdt_msgs_py.quantities import Quantity, check, quantities_of, quantity, validate

LENGTH = Quantity("m", "a length", 0.0, 2.0)
COLOR = Quantity("", "a color", choices=("red", "blue"))
FREE = Quantity("", "anything")


@dataclass(frozen=True)
class Example:
    """One field of every type."""

    length: float = quantity(1.0, "m", "a length", minimum=0.0, maximum=2.0, reconfigurable=True)
    count: int = quantity(3, "samples", "a count", minimum=1, maximum=9)
    enabled: bool = quantity(True, "", "a switch")
    color: str = quantity("red", "", "a color", choices=("red", "blue"))
    name: str = quantity("twin", "", "a name")
    gaps: tuple[float, ...] = quantity((0.0, 1.0), "rad", "gaps", minimum=0.0, maximum=2.0)
    nodes: tuple[str, ...] = quantity(("",), "", "names of nodes")
    undescribed: float = 0.0

    def __post_init__(self):
        validate(self)


@pytest.mark.parametrize("value", [0.0, 2.0, 1, 0, np.float64(1.5), math.nextafter(2.0, 0.0)])
def test_a_number_within_its_range_is_accepted_bounds_included(value):
    check("length", value, 1.0, LENGTH)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (-1e-9, r"length = -1e-09 m: must be 0 to 2 m"),
        (math.nextafter(2.0, 3.0), r"length = 2\.0000000000000004 m: must be 0 to 2 m"),
        (3, r"length = 3 m: must be 0 to 2 m"),
        (math.nan, r"length = nan m: must be 0 to 2 m"),
        (math.inf, r"length = inf m: must be 0 to 2 m"),
        (-math.inf, r"length = -inf m: must be 0 to 2 m"),
        (True, r"length = True: must be a number, 0 to 2 m"),
        (False, r"length = False: must be a number, 0 to 2 m"),
        ("1.0", r"length = '1\.0': must be a number, 0 to 2 m"),
        (None, r"length = None: must be a number, 0 to 2 m"),
        ([1.0], r"length = \[1\.0\]: must be a number, 0 to 2 m"),
        (1j, r"length = 1j: must be a number, 0 to 2 m"),
    ],
)
def test_a_wrong_number_is_named_with_its_value_and_what_is_allowed(value, text):
    with pytest.raises(ValueError, match=f"^{text}$"):
        check("length", value, 1.0, LENGTH)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_number_must_be_finite_even_where_everything_is_allowed(value):
    with pytest.raises(ValueError, match=rf"^x = {value}.*must be any"):
        check("x", value, 1.0, FREE)


@pytest.mark.parametrize("value", [1, 9])
def test_an_integer_within_its_range_is_accepted(value):
    assert Example(count=value).count == value


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, r"count = 0 samples: must be 1 to 9 samples"),
        (10, r"count = 10 samples: must be 1 to 9 samples"),
        (3.0, r"count = 3\.0: must be an integer, 1 to 9 samples"),
        (True, r"count = True: must be an integer, 1 to 9 samples"),
        ("3", r"count = '3': must be an integer, 1 to 9 samples"),
        (math.nan, r"count = nan: must be an integer, 1 to 9 samples"),
    ],
)
def test_a_wrong_integer_is_named_with_its_value_and_what_is_allowed(value, text):
    with pytest.raises(ValueError, match=rf"^Example\.{text}$"):
        Example(count=value)


@pytest.mark.parametrize("value", [1, 0, 1.0, "true", None, []])
def test_a_switch_takes_only_true_and_false(value):
    with pytest.raises(ValueError, match=r"^Example\.enabled = .*: must be true or false$"):
        Example(enabled=value)


@pytest.mark.parametrize(
    ("value", "shown"), [("green", "'green'"), ("", "''"), ("Red", "'Red'"), (1, "1")]
)
def test_a_choice_must_be_one_of_those_listed(value, shown):
    with pytest.raises(ValueError, match=rf"^Example\.color = {shown}: must be one of red, blue$"):
        Example(color=value)


@pytest.mark.parametrize("value", [1, None, True, ["twin"]])
def test_a_text_must_be_a_text(value):
    with pytest.raises(ValueError, match=r"^Example\.name = .*: must be a text$"):
        Example(name=value)


def test_without_choices_every_text_is_allowed():
    assert Example(name="").name == ""


@pytest.mark.parametrize("value", [(), (0.5,), [0.5, 1], (2.0,) * 9])
def test_a_list_may_have_any_length(value):
    assert Example(gaps=value).gaps == value


@pytest.mark.parametrize("value", [0.5, "0.5", None, {0.5}, {0.5: 1}])
def test_a_list_must_be_a_list(value):
    with pytest.raises(ValueError, match=r"^Example\.gaps = .*: must be a list$"):
        Example(gaps=value)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ((0.5, 3.0), r"gaps\[1\] = 3\.0 rad: must be 0 to 2 rad"),
        ((math.nan, 3.0), r"gaps\[0\] = nan rad: must be 0 to 2 rad"),
        ((0.5, 0.5, math.inf), r"gaps\[2\] = inf rad: must be 0 to 2 rad"),
        ((0.5, True), r"gaps\[1\] = True: must be a number, 0 to 2 rad"),
        (("0.5",), r"gaps\[0\] = '0\.5': must be a number, 0 to 2 rad"),
        (((0.5,),), r"gaps\[0\] = \(0\.5,\): must be a number, 0 to 2 rad"),
    ],
)
def test_a_wrong_item_of_a_list_is_named_with_its_place(value, text):
    with pytest.raises(ValueError, match=rf"^Example\.{text}$"):
        Example(gaps=value)


def test_a_wrong_text_in_a_list_is_named_with_its_place():
    with pytest.raises(ValueError, match=r"^Example\.nodes\[1\] = 3: must be a text$"):
        Example(nodes=("twin", 3))


def test_every_message_is_one_line():
    with pytest.raises(ValueError, match="must be one of") as refusal:
        Example(color="two\nlines")
    assert "\n" not in str(refusal.value)


def test_the_first_wrong_field_is_the_one_named():
    with pytest.raises(ValueError, match=r"^Example\.length"):
        Example(length=-1.0, count=0)


def test_the_quantities_of_a_dataclass_come_with_name_and_default_in_order():
    listed = list(quantities_of(Example))
    assert [name for name, _, _ in listed] == [
        "length",
        "count",
        "enabled",
        "color",
        "name",
        "gaps",
        "nodes",
    ]
    assert listed[0] == ("length", 1.0, Quantity("m", "a length", 0.0, 2.0, (), True))
    assert list(quantities_of(Example(length=2.0))) == listed  # defaults, not values


@pytest.mark.parametrize(
    ("described", "phrase"),
    [
        (LENGTH, "0 to 2 m"),
        (COLOR, "one of red, blue"),
        (FREE, "any"),
        (Quantity("", "", 1, 2), "1 to 2"),
    ],
)
def test_what_is_allowed_is_a_phrase(described, phrase):
    assert described.allowed() == phrase


def test_what_a_value_has_to_be_names_its_kind_and_what_is_allowed_of_it():
    assert LENGTH.rule("a number") == "a number, 0 to 2 m"
    assert FREE.rule("a number") == "a number"


@pytest.mark.parametrize("value", [10**400, -(10**400)])
def test_an_integer_too_large_for_a_float_is_out_of_range_like_any_other(value):
    described = Quantity("m", "a length", minimum=0.0, maximum=1.0)
    with pytest.raises(ValueError, match="must be 0 to 1 m"):
        check("length", value, 0.5, described)


def test_bytes_are_not_a_list_of_numbers():
    described = Quantity("m", "lengths", minimum=0.0, maximum=255.0)
    with pytest.raises(ValueError, match="must be a list"):
        check("lengths", b"\x01\x02", (0.5,), described)


def test_a_range_with_one_end_says_so():
    assert Quantity("s", "a time", minimum=0.0).allowed() == "at least 0 s"
    assert Quantity("s", "a time", maximum=9.0).allowed() == "at most 9 s"
