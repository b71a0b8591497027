"""Fields of a parameter dataclass as options of a command."""

from argparse import ArgumentParser
from dataclasses import dataclass

import pytest

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.quantities import quantity, validate
from bdt_msgs_py.quantity_options import add_quantity_options, quantities_from_options


@dataclass(frozen=True)
class Paint:
    """A set of texts and numbers."""

    name: str = quantity("", "", "what it is called")
    finish_kind: str = quantity("matte", "", "how it shines", choices=("matte", "gloss"))
    layers: int = quantity(2, "", "how often", minimum=1, maximum=5)
    drying_time: float = quantity(3.0, "s", "how long", minimum=0.0, maximum=9.0)

    def __post_init__(self):
        validate(self)


NAMES = ("finish_kind", "layers", "drying_time")


def painted(*arguments, **others):
    parser = ArgumentParser()
    add_quantity_options(parser, Paint, NAMES)
    return quantities_from_options(Paint, parser.parse_args(arguments), NAMES, **others)


def test_without_options_everything_has_its_default():
    assert painted() == Paint()


def test_options_are_named_after_the_fields_and_typed():
    assert painted("--finish-kind", "gloss", "--layers", "3", "--drying-time", "4") == Paint(
        finish_kind="gloss", layers=3, drying_time=4.0
    )


def test_other_fields_are_given_by_the_caller():
    assert painted(name="door").name == "door"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--finish-kind", "dull"], "--finish-kind = 'dull': must be one of matte, gloss"),
        (["--layers", "9"], "--layers = 9: must be 1 to 5"),
        (["--drying-time", "nan"], "--drying-time = nan s: must be 0 to 9 s"),
    ],
)
def test_what_is_not_allowed_is_one_line_with_the_option(arguments, says):
    with pytest.raises(BadInputError) as caught:
        painted(*arguments)
    assert str(caught.value) == says


def test_the_help_says_meaning_choices_and_default(capsys):
    parser = ArgumentParser()
    add_quantity_options(parser, Paint, NAMES)
    parser.print_help()
    said = " ".join(capsys.readouterr().out.split())
    assert "--finish-kind KIND how it shines: matte or gloss (default: matte)" in said
    assert "--drying-time S how long (default: 3.0)" in said
