"""Reference r(t): stepwise constant, as a square wave or a table of steps."""

import math
from bisect import bisect_right
from dataclasses import dataclass

from bdt_msgs_py.quantities import quantity, validate, validate_table

KINDS = ("square", "table", "topic")

# A step begins at its nominal time although t and the step's length are binary fractions.
_TIME_TOLERANCE = 1e-9


@dataclass(frozen=True)
class ReferenceProfile:
    """Source of the reference; the paper shows steps and leaves amplitude and length open."""

    kind: str = quantity(
        "square",
        "",
        "square wave, table of steps, or the topic reference of another node",
        choices=KINDS,
    )
    first: float = quantity(
        5e-3,
        "m",
        "level of the odd steps of the square wave, from the first",
        minimum=-1e3,
        maximum=1e3,
    )
    second: float = quantity(0.0, "m", "level of the even steps", minimum=-1e3, maximum=1e3)
    step_time: float = quantity(
        10.0, "s", "length of each step of the square wave", minimum=1e-3, maximum=1e9
    )
    table_times: tuple[float, ...] = quantity(
        (0.0,), "s", "strictly increasing beginnings of the steps", minimum=0.0, maximum=1e9
    )
    table_positions: tuple[float, ...] = quantity(
        (5e-3,), "m", "levels of the steps", minimum=-1e3, maximum=1e3
    )

    def __post_init__(self) -> None:
        validate(self)
        validate_table(self, "table_times", "table_positions")


def reference_at(reference: ReferenceProfile, time: float) -> float:
    """Return r [m] at `time` [s]; zero before the first step of a table.

    Raises
    ------
    ValueError
        If the reference comes from a topic: then only the topic knows it.
    """
    if reference.kind == "square":
        step = math.floor((time + _TIME_TOLERANCE) / reference.step_time)
        return reference.second if step % 2 else reference.first
    if reference.kind == "table":
        step = bisect_right(reference.table_times, time + _TIME_TOLERANCE)
        return reference.table_positions[step - 1] if step else 0.0
    raise ValueError("ReferenceProfile.kind = 'topic': has no value of its own")
