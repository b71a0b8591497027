"""Pushes on a platform: somebody leans on the machine, now and then."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from bdt_msgs_py.quantities import quantity, validate

MASK = 0x7FFFFFFF
"""Keeps the numbers of the random signs below 2^31, so that products fit into 64 bits."""


@dataclass(frozen=True)
class PushParameters:
    """Pushes on a platform; the paper has none."""

    force: float = quantity(0.0, "N", "force of a push; 0 for none", minimum=0.0, maximum=1e6)
    duration: float = quantity(0.05, "s", "time that a push takes", minimum=1e-4, maximum=1e3)
    period: float = quantity(
        7.0, "s", "time from one push to the next, and to the first", minimum=1e-3, maximum=1e6
    )
    platform: int = quantity(3, "", "platform that is pushed, 2 or 3", minimum=2, maximum=3)
    seed: int = quantity(
        0, "", "seed of random directions; 0 for turns", minimum=0, maximum=2_147_483_647
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.duration > self.period:
            raise ValueError(
                f"PushParameters.duration = {self.duration!r} s: "
                f"must be at most period ({self.period:g} s)"
            )

    def fall_between(self, begin: float, end: float) -> bool:
        """Tell whether a push begins in a time from `begin` to before `end` [s]."""
        first = max(math.ceil(begin / self.period), 1)
        return self.force > 0.0 and first * self.period < end


class Pushes(NamedTuple):
    """Pushes at one sampling rate.

    Attributes
    ----------
    force : float
        Force [N].
    duration, period : int
        Samples of a push, and from one to the next.
    platform : int
        2 or 3.
    seed : int
        Seed of the directions; 0 for turns.
    """

    force: float
    duration: int
    period: int
    platform: int
    seed: int


def discretize_pushes(parameters: PushParameters, sampling_rate: float) -> Pushes:
    """Return pushes in whole samples at `sampling_rate` [Hz]."""
    return Pushes(
        float(parameters.force),
        max(round(parameters.duration * sampling_rate), 1),
        max(round(parameters.period * sampling_rate), 1),
        int(parameters.platform),
        int(parameters.seed),
    )


def push_force(sample: int, pushes: Pushes) -> float:
    """Return the force on the platform from a sample to the next [N].

    Parameters
    ----------
    sample : int
        Number of the sample, from 0.
    pushes : Pushes
        From :func:`discretize_pushes`.
    """
    number = sample // pushes.period
    if pushes.force == 0.0 or number == 0 or sample % pushes.period >= pushes.duration:
        return 0.0
    return pushes.force if _is_forward(number, pushes.seed) else -pushes.force


def _is_forward(number: int, seed: int) -> bool:
    """Tell the direction of a push from its number, from 1 on."""
    if seed == 0:
        return number % 2 == 1
    mixed = (seed * 1103515245 + number * 668265263) & MASK
    mixed = ((mixed ^ (mixed >> 15)) * 739982445) & MASK
    mixed = ((mixed ^ (mixed >> 12)) * 695872825) & MASK
    return (mixed >> 20) % 2 == 0
