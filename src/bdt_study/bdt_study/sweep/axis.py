"""One parameter that a study varies: on a grid, or drawn from a distribution."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any

DISTRIBUTIONS = ("uniform", "log_uniform", "normal")

NORMAL_REACH = 4.0
"""Standard deviations beyond which a normal distribution is cut off: every value is checked before
anything runs."""

STANDARD = NormalDist()


@dataclass(frozen=True)
class Axis:
    """A parameter with the values that it takes.

    Attributes
    ----------
    name : str
        Node and flat name: ``plant.gap.initial``.
    values : tuple
        Values of a grid; empty for a distribution.
    distribution : str
        One of ``DISTRIBUTIONS``; empty for a grid.
    first, second : float
        Ends of a uniform or log-uniform distribution, mean and standard deviation of a normal one.
    also : tuple of str
        Other parameters that have the same value in each run.
    """

    name: str
    values: tuple[Any, ...] = ()
    distribution: str = ""
    first: float = 0.0
    second: float = 0.0
    also: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if bool(self.values) == bool(self.distribution):
            raise ValueError(f"{self.name}: must have values or a distribution")
        if self.values:
            return
        if self.distribution not in DISTRIBUTIONS:
            raise ValueError(
                f"{self.name}.distribution = {self.distribution!r}: "
                f"must be one of {', '.join(DISTRIBUTIONS)}"
            )
        label = f"{self.name}.{self.distribution} = [{self.first!r}, {self.second!r}]"
        if not (math.isfinite(self.first) and math.isfinite(self.second)):
            raise ValueError(f"{label}: must be two finite numbers")
        if self.distribution == "normal":
            if self.second <= 0.0:
                raise ValueError(f"{label}: the standard deviation must be above 0")
        elif self.second <= self.first:
            raise ValueError(f"{label}: must increase")
        if self.distribution == "log_uniform" and self.first <= 0.0:
            raise ValueError(f"{label}: must be above 0")

    @property
    def is_grid(self) -> bool:
        """Whether the values stand in the study, rather than being drawn."""
        return bool(self.values)

    @property
    def names(self) -> Iterator[str]:
        """All parameters that have the value."""
        yield self.name
        yield from self.also

    @property
    def extremes(self) -> tuple[Any, ...]:
        """Values to check before anything runs: all of a grid, the ends of a distribution."""
        return self.values or (self.value_at(0.0), self.value_at(1.0))

    def value_at(self, fraction: float) -> float:
        """Return the value of a distribution below which a fraction of 0 to 1 lies."""
        if self.distribution == "normal":
            low, high = STANDARD.cdf(-NORMAL_REACH), STANDARD.cdf(NORMAL_REACH)
            deviations = STANDARD.inv_cdf(low + (high - low) * fraction)
            return self.first + self.second * min(max(deviations, -NORMAL_REACH), NORMAL_REACH)
        if self.distribution == "log_uniform":
            ratio = math.log(self.second / self.first)
            return min(max(self.first * math.exp(ratio * fraction), self.first), self.second)
        return min(self.first + (self.second - self.first) * fraction, self.second)
