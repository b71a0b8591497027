"""Growth of the backlash gap with wear: theta_b as a function of time."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bdt_msgs_py.quantities import quantity, validate, validate_table
from bdt_plant.elementary_functions import power

FloatArray = NDArray[np.float64]

KINDS = ("constant", "ramp", "power_law", "table")


@dataclass(frozen=True)
class GapProfile:
    """Gap profile; the default is the scenario behind figures 3, 4, 6 and 7.

    The paper shows a growing gap with a mean of 10 degrees and leaves the law open. The default
    is 30 degrees times (t / 120 s) squared, whose mean over 120 s is 10 degrees.
    """

    kind: str = quantity("power_law", "", "law of growth", choices=KINDS, reconfigurable=True)
    initial: float = quantity(
        0.0,
        "rad",
        "gap at the beginning; the gap of kind constant",
        minimum=0.0,
        maximum=100.0,
        reconfigurable=True,
    )
    final: float = quantity(
        float(np.deg2rad(30.0)),
        "rad",
        "gap at the end of the growth",
        minimum=0.0,
        maximum=100.0,
        reconfigurable=True,
    )
    growth_time: float = quantity(
        120.0,
        "s",
        "time over which the gap grows; it stays there",
        minimum=1e-3,
        maximum=1e9,
        reconfigurable=True,
    )
    exponent: float = quantity(
        2.0,
        "",
        "exponent of the power law; 1 is the ramp",
        minimum=0.1,
        maximum=10.0,
        reconfigurable=True,
    )
    table_times: tuple[float, ...] = quantity(
        (0.0, 120.0), "s", "strictly increasing times of the table", minimum=0.0, maximum=1e9
    )
    table_gaps: tuple[float, ...] = quantity(
        (0.0, float(np.deg2rad(30.0))), "rad", "gaps of the table", minimum=0.0, maximum=100.0
    )
    begin_time: float = quantity(
        0.0,
        "s",
        "time at which the growth, or the table, begins",
        minimum=0.0,
        maximum=1e9,
        reconfigurable=True,
    )

    def __post_init__(self) -> None:
        validate(self)
        validate_table(self, "table_times", "table_gaps")


def gap_at(profile: GapProfile, time: float) -> float:
    """Return the backlash gap theta_b [rad] at `time` [s]."""
    return float(gaps_at(profile, np.array([time]))[0])


def gaps_at(profile: GapProfile, times: FloatArray) -> FloatArray:
    """Return the backlash gap theta_b [rad] at times [s] of shape (n,), the same on any computer.

    numpy's own power and interpolation are not: they round as suits the processor.
    """
    if profile.kind == "constant":
        return np.full(times.size, profile.initial, dtype=np.float64)
    elapsed = times - profile.begin_time
    if profile.kind == "table":
        return _gaps_of_table(profile, elapsed)
    fractions = np.clip(elapsed / profile.growth_time, 0.0, 1.0)
    if profile.kind == "power_law":
        fractions = power(fractions, profile.exponent)
    return profile.initial + (profile.final - profile.initial) * fractions


def _gaps_of_table(profile: GapProfile, times: FloatArray) -> FloatArray:
    """Return the gaps of a table, joined by straight lines and constant beyond its ends."""
    instants = np.array(profile.table_times, dtype=np.float64)
    gaps = np.array(profile.table_gaps, dtype=np.float64)
    rows = np.maximum(np.searchsorted(instants, times, side="right") - 1, 0)
    rises, spans = np.append(np.diff(gaps), 0.0), np.append(np.diff(instants), 1.0)
    shares = (np.maximum(times, instants[0]) - instants[rows]) / spans[rows]
    joined: FloatArray = gaps[rows] + rises[rows] * shares
    return joined
