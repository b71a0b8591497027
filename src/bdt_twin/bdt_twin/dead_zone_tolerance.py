"""Width of the controller's dead zone for an estimated gap (eq. 9)."""

import math
from dataclasses import dataclass

import numpy as np

from bdt_msgs_py.quantities import quantity, validate
from bdt_twin.estimator import Estimate


@dataclass(frozen=True)
class DeadZoneSettings:
    """What the twin commands for an estimate; the defaults command eq. 9 as it stands."""

    coverage_factor: float = quantity(
        0.0,
        "",
        "standard uncertainties of the gap that are added to the estimate; 2 for an upper bound "
        "with 98 % confidence",
        minimum=0.0,
        maximum=10.0,
    )
    ratio: float = quantity(
        1.0,
        "",
        "factor on the gap of eq. 9; gains that are designed for the mechanism need less than 1",
        minimum=0.0,
        maximum=10.0,
    )
    margin: float = quantity(
        0.0,
        "rad",
        "gap that is added to the estimate for a loop that settles quickly: with a dead zone just "
        "as wide as the gap it rings for long",
        minimum=0.0,
        maximum=1.0,
    )
    horizon: float = quantity(
        0.0,
        "s",
        "time for which a dead zone is to hold once it is in force: until the next one comes",
        minimum=0.0,
        maximum=1e3,
    )
    largest_growth: float = quantity(
        float(np.deg2rad(20.0)),
        "rad",
        "largest gap that is added to the estimate for growth and uncertainty together: in a loop "
        "that rests nothing is learned, and without a bound both would grow until the dead zone "
        "is wider than the next step",
        minimum=0.0,
        maximum=100.0,
    )
    minimum: float = quantity(
        0.0, "m", "smallest tolerance that is commanded", minimum=0.0, maximum=1.0
    )
    maximum: float = quantity(
        1.0, "m", "largest tolerance that is commanded", minimum=0.0, maximum=1.0
    )
    rate_limit: float = quantity(
        1.0, "m/s", "largest change of the tolerance in simulated time", minimum=1e-9, maximum=1.0
    )

    def __post_init__(self) -> None:
        validate(self)
        if self.minimum > self.maximum:
            raise ValueError(
                f"DeadZoneSettings.minimum = {self.minimum!r} m: "
                f"must be at most maximum ({self.maximum:g} m)"
            )


EQUATION_9 = DeadZoneSettings()
"""The estimate as it is, without margin."""


def tolerance_for_gap(gap: float, pitch: float) -> float:
    """Return the dead-zone tolerance epsilon_dz = p theta_b [m] (eq. 9).

    Parameters
    ----------
    gap : float
        Estimated backlash gap theta_b [rad].
    pitch : float
        Pitch p of the lead screw [m/rad].
    """
    return pitch * max(gap, 0.0)


def gap_bound(estimate: Estimate, time: float, coverage_factor: float) -> float:
    """Return an upper bound of the gap [rad] at a time after the estimate.

    Parameters
    ----------
    estimate : Estimate
        What is known; its gap must be.
    time : float
        Time at which the bound has to hold [s].
    coverage_factor : float
        Standard uncertainties to add. An estimator that knows none adds nothing.
    """
    age = max(time - estimate.time, 0.0)
    # A gap wears out and does not heal: a negative growth rate is noise.
    growth = max(estimate.growth, 0.0) * age
    by_growth = estimate.growth_uncertainty * age
    doubt = math.sqrt(estimate.uncertainty * estimate.uncertainty + by_growth * by_growth)
    margin = coverage_factor * doubt if math.isfinite(doubt) else 0.0
    return estimate.gap + growth + margin


class DeadZoneRule:
    """Turns estimates into tolerances, within range and rate.

    Parameters
    ----------
    settings : DeadZoneSettings
        Margin, range and rate.
    pitch : float
        Pitch p of the lead screw [m/rad].

    Attributes
    ----------
    is_bounded : bool
        Whether doubt asks for more than ``largest_growth`` in the last tolerance.
    """

    def __init__(self, settings: DeadZoneSettings, pitch: float) -> None:
        self._settings = settings
        self._pitch = pitch
        self.restart()

    def restart(self) -> None:
        """Forget what was commanded; the next tolerance may be any in the range."""
        self._last: tuple[float, float] | None = None
        self.is_bounded = False

    def resume(self, tolerance: float, time: float) -> None:
        """Go on from a tolerance [m] that is in force at a time [s]."""
        self._last = (time, tolerance)

    def tolerance(self, estimate: Estimate, time: float) -> float:
        """Return the tolerance epsilon_dz [m] that is to take effect at `time` [s]."""
        return self.limited(self.wanted(estimate, time), time)

    def wanted(self, estimate: Estimate, time: float) -> float:
        """Return the tolerance [m] for a time [s] without range and rate."""
        settings = self._settings
        bound = gap_bound(estimate, time + settings.horizon, settings.coverage_factor)
        largest = estimate.gap + settings.largest_growth
        self.is_bounded = bound > largest
        bound = min(bound, largest)
        return tolerance_for_gap(settings.ratio * bound + settings.margin, self._pitch)

    def limited(self, wanted: float, time: float) -> float:
        """Return the tolerance within range and rate that is nearest to a wanted one [m].

        Parameters
        ----------
        wanted : float
            Tolerance [m].
        time : float
            Time at which it is to take effect [s].
        """
        settings = self._settings
        wanted = min(max(wanted, settings.minimum), settings.maximum)
        if self._last is not None:
            before, last = self._last
            change = settings.rate_limit * max(time - before, 0.0)
            wanted = min(max(wanted, last - change), last + change)
        self._last = (time, wanted)
        return wanted
