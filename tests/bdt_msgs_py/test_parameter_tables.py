"""A node's table of parameters, looked into without the node."""

from dataclasses import dataclass

import pytest
import yaml

from bdt_msgs_py.command_errors import BadInputError
from bdt_msgs_py.parameter_tables import (
    check_value,
    in_parameter_names,
    known_parameters,
    parameter_sets,
    ros_arguments,
    suggestion,
)
from bdt_msgs_py.quantities import quantity, validate


@dataclass(frozen=True)
class Spring:
    """A set with values that must go together."""

    stiffness: float = quantity(2.0, "N/m", "stiffness", minimum=0.0, maximum=10.0)
    ends: tuple[float, ...] = quantity((0.0, 1.0), "m", "ends", minimum=-1.0, maximum=1.0)

    def __post_init__(self):
        validate(self)
        if self.stiffness > 5.0 and len(self.ends) < 2:
            raise ValueError(f"Spring.ends = {self.ends}: must be two for a stiff spring")


@dataclass(frozen=True)
class Pace:
    """A set without a prefix."""

    rate: int = quantity(5, "Hz", "rate", minimum=1, maximum=9)


TABLE = (("", Pace), ("front.spring", Spring))


def test_names_are_flat_with_their_prefix():
    known = known_parameters(TABLE)
    assert list(known) == ["rate", "front.spring.stiffness", "front.spring.ends"]
    default, described = known["front.spring.stiffness"]
    assert (default, described.unit) == (2.0, "N/m")


def test_sets_hold_what_is_given_and_the_default_for_the_rest():
    pace, spring = parameter_sets(TABLE, {"front.spring.ends": [0.5]})
    assert pace == Pace()
    assert spring == Spring(ends=(0.5,))


def test_values_that_do_not_go_together_are_refused():
    values = {"front.spring.stiffness": 6.0, "front.spring.ends": [0.0]}
    with pytest.raises(ValueError, match=r"Spring\.ends") as caught:
        parameter_sets(TABLE, values)
    assert in_parameter_names(str(caught.value), TABLE).startswith("front.spring.ends = (0.0,)")


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("rate", 10, "x = 10 Hz: must be 1 to 9 Hz"),
        ("rate", 2.0, "x = 2.0: must be an integer"),
        ("front.spring.stiffness", 1, "x = 1: must be written with a decimal point"),
        ("front.spring.ends", [0.0, 1], "must be written with a decimal point"),
        ("front.spring.ends", [2.0], r"x\[0\] = 2.0 m: must be -1 to 1 m"),
    ],
)
def test_a_value_is_checked_as_strictly_as_a_node_would(name, value, says):
    with pytest.raises(BadInputError, match=says):
        check_value("x", value, *known_parameters(TABLE)[name])


def test_a_misspelt_name_gets_a_suggestion_and_a_strange_one_none():
    known = known_parameters(TABLE)
    assert suggestion("front.spring.stifness", known) == ("; did you mean front.spring.stiffness?")
    assert suggestion("qqq", known) == ""


def test_ros_arguments_are_yaml_of_the_same_values():
    values = {"rate": 5, "mode": "lock: step", "on": True, "ends": [0.5, -2.0], "names": ["a"]}
    arguments = ros_arguments(values)
    assert arguments[::2] == ["-p"] * len(values)
    read = dict(text.split(":=", 1) for text in arguments[1::2])
    assert {name: yaml.safe_load(text) for name, text in read.items()} == values
