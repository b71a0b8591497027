"""Growth of the backlash gap with wear: theta_b as a function of time."""

from dataclasses import dataclass
from itertools import repeat

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate, validate_table

KINDS = ("constant", "ramp", "power_law", "table")


@dataclass(frozen=True)
class GapProfile:
    """Gap profile; the default is the scenario behind figures 3, 4, 6 and 7.

    The paper shows a growing gap with a mean of 10 degrees and leaves the law open. The default
    is 30 degrees times (t / 120 s) squared, whose mean over 120 s is 10 degrees.
    """

    kind: str = quantity("power_law", "", "law of growth", choices=KINDS)
    initial: float = quantity(
        0.0, "rad", "gap at the beginning; the gap of kind constant", minimum=0.0, maximum=100.0
    )
    final: float = quantity(
        float(np.deg2rad(30.0)), "rad", "gap at the end of the growth", minimum=0.0, maximum=100.0
    )
    growth_time: float = quantity(
        120.0, "s", "time over which the gap grows; it stays there", minimum=1e-3, maximum=1e9
    )
    exponent: float = quantity(
        2.0, "", "exponent of the power law; 1 is the ramp", minimum=0.1, maximum=10.0
    )
    table_times: tuple[float, ...] = quantity(
        (0.0, 120.0), "s", "strictly increasing times of the table", minimum=0.0, maximum=1e9
    )
    table_gaps: tuple[float, ...] = quantity(
        (0.0, float(np.deg2rad(30.0))), "rad", "gaps of the table", minimum=0.0, maximum=100.0
    )

    def __post_init__(self) -> None:
        validate(self)
        validate_table(self, "table_times", "table_gaps")


def gap_at(profile: GapProfile, time: float) -> float:
    """Return the backlash gap theta_b [rad] at `time` [s]."""
    if profile.kind == "constant":
        return profile.initial
    if profile.kind == "table":
        return float(np.interp(time, profile.table_times, profile.table_gaps))
    fraction = min(max(time / profile.growth_time, 0.0), 1.0)
    if profile.kind == "power_law":
        fraction = fraction**profile.exponent
    return profile.initial + (profile.final - profile.initial) * fraction


def gaps_at(profile: GapProfile, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return :func:`gap_at` for times [s] of shape (n,), element by element the same floats."""
    if profile.kind == "constant":
        return np.full(times.size, profile.initial, dtype=np.float64)
    if profile.kind == "table":
        return np.interp(times, profile.table_times, profile.table_gaps)
    fractions = np.clip(times / profile.growth_time, 0.0, 1.0)
    if profile.kind == "power_law":
        # numpy's power rounds otherwise than Python's, and on each processor in its own way.
        powers = map(pow, fractions.tolist(), repeat(profile.exponent))
        fractions = np.fromiter(powers, np.float64, times.size)
    return profile.initial + (profile.final - profile.initial) * fractions
