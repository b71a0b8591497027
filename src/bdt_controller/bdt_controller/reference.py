"""Reference r(t): a square wave, a table of steps, or the motions of commissioning."""

import math
from bisect import bisect_right
from dataclasses import dataclass

from bdt_controller.commissioning import level_at, longest_travel_time
from bdt_msgs_py.quantities import quantity, validate, validate_table

KINDS = ("square", "table", "commissioning", "topic")

# A step begins at its nominal time although t and the step's length are binary fractions.
_TIME_TOLERANCE = 1e-9


@dataclass(frozen=True)
class ReferenceProfile:
    """Source of the reference; the paper shows steps and leaves amplitude and length open."""

    kind: str = quantity(
        "square",
        "",
        "square wave, table of steps, a minute of steps, slow reversals and rests for "
        "commissioning, or the topic reference of another node",
        choices=KINDS,
    )
    first: float = quantity(
        5e-3,
        "m",
        "level of the odd steps of the square wave, from the first; end of the travel of "
        "commissioning",
        minimum=-1e3,
        maximum=1e3,
        reconfigurable=True,
    )
    second: float = quantity(
        0.0,
        "m",
        "level of the even steps; where commissioning begins and ends",
        minimum=-1e3,
        maximum=1e3,
        reconfigurable=True,
    )
    step_time: float = quantity(
        10.0,
        "s",
        "length of each step of the square wave",
        minimum=1e-3,
        maximum=1e9,
        reconfigurable=True,
    )
    largest_speed: float = quantity(
        0.05,
        "m/s",
        "speed of the reference in the steps of commissioning, its fastest motions",
        minimum=1e-9,
        maximum=1e3,
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
        if self.kind == "commissioning":
            self._validate_commissioning()

    @property
    def travel_time(self) -> float:
        """Time from one end of the travel to the other at the largest speed [s]."""
        return abs(self.first - self.second) / self.largest_speed

    def _validate_commissioning(self) -> None:
        if self.first == self.second:
            raise ValueError(
                f"ReferenceProfile.first = {self.first!r} m: must differ from second, so that "
                "there is a travel for commissioning"
            )
        longest = longest_travel_time()
        if self.travel_time > longest:
            travel = abs(self.first - self.second)
            raise ValueError(
                f"ReferenceProfile.largest_speed = {self.largest_speed!r} m/s: must be at least "
                f"{travel / longest:g} m/s for a travel of {travel:g} m in commissioning"
            )


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
    if reference.kind == "commissioning":
        level = level_at(time, reference.travel_time)
        return reference.second + (reference.first - reference.second) * level
    if reference.kind == "table":
        step = bisect_right(reference.table_times, time + _TIME_TOLERANCE)
        return reference.table_positions[step - 1] if step else 0.0
    raise ValueError("ReferenceProfile.kind = 'topic': has no value of its own")
