"""What the fit of a window looks for, as an object and as a vector."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bdt_twin.machine_knowledge import EFFECT_LIMITS, EFFECTS, TOP_MASS, VOLTAGE_LAG, YIELD_ANGLE
from bdt_twin.model_factors import FACTORS

FloatArray = NDArray[np.float64]

INITIAL_CONDITION = ("share", "offset", "q2", "q2_velocity", "q3", "q3_velocity")
"""Unknowns at the beginning of a stretch; see :class:`Unknowns`."""
MOST_EXCESS = 1.0
"""Largest excess of friction at rest over that of a fast motor, as a share of it."""

SMALLEST_YIELD_ANGLE = 3e-4
"""Yield angle below which friction is rigid [rad]."""
SMALLEST_LAG = 1e-6
"""Time constant below which a voltage follows its command at once [s]."""
LATE = 4e-4
"""Age of a reading from which on it matters whether the voltage is late instead, and time from
which on that is late [s]."""
EARLY_SHARE = 0.15
"""Share of a lag by which a reading may be early beside it: it is as sure as that."""
GAP_PER_ANGLE = 1.5
"""By how much larger a gap seems for friction that yields, over the yield angle."""


@dataclass(frozen=True, eq=False)
class Unknowns:
    """Everything that a fit looks for.

    Attributes
    ----------
    gaps : ndarray, shape (knots,)
        Gap theta_b at the knots, linear between them [rad].
    factors : ndarray, shape (3,)
        Natural logarithms of ``model_factors.FACTORS``.
    initial_conditions : ndarray, shape (stretches, 6)
        ``INITIAL_CONDITION`` of each stretch: where in the gap the motor is, from -1 to 1 (ends at
        which it drives the screw backward and forward), the position of the lead screw's end [m],
        and the structure's positions [m] relative to it and velocities [m/s].
    effects : ndarray, shape (effects,)
        ``machine_knowledge.EFFECTS``.
    """

    gaps: FloatArray
    factors: FloatArray
    initial_conditions: FloatArray
    effects: FloatArray = field(default_factory=lambda: np.zeros(len(EFFECTS)))

    @property
    def friction(self) -> float:
        """Voltage that the motor's Coulomb friction takes [V]."""
        return float(self.effects[EFFECTS.index("friction_voltage")])

    @property
    def model_factors(self) -> FloatArray:
        """Natural logarithms of ``model_factors.MODEL_FACTORS``, shape (4,)."""
        return np.append(self.factors, self.effects[TOP_MASS])

    def with_yield_angle(self, angle: float) -> "Unknowns":
        """Return them for friction that yields by another angle [rad], with gaps that go with it.

        Parameters
        ----------
        angle : float
            The yield angle [rad]; 0 for rigid friction.
        """
        effects = self.effects.copy()
        gaps = self.gaps + GAP_PER_ANGLE * (angle - float(effects[YIELD_ANGLE]))
        effects[YIELD_ANGLE] = angle
        return replace(self, gaps=np.maximum(gaps, 0.0), effects=effects)

    @property
    def has_late_voltage(self) -> bool:
        """Whether a voltage is late that is not held to be that for a reading which is early."""
        lag, delay = float(self.effects[VOLTAGE_LAG]), float(self.effects[EFFECTS.index("delay")])
        return lag > LATE and delay > -EARLY_SHARE * lag

    def with_late_voltage(self) -> "Unknowns":
        """Return them for a voltage that is as late as the reading was, which is not late then."""
        effects, delay = self.effects.copy(), EFFECTS.index("delay")
        effects[VOLTAGE_LAG] += effects[delay]
        effects[delay] = 0.0
        return replace(self, effects=effects)

    def with_effects(self, places: Sequence[int], size: float) -> "Unknowns":
        """Return them with these places of ``EFFECTS`` of one size, in their units."""
        effects = self.effects.copy()
        effects[list(places)] = size
        return replace(self, effects=effects)

    def as_vector(self) -> FloatArray:
        """Return all of them in one array."""
        parts = (self.gaps, self.factors, self.effects, self.initial_conditions.ravel())
        return np.concatenate(parts)

    def from_vector(self, vector: FloatArray) -> "Unknowns":
        """Return the unknowns of a vector, brought back to where they have a meaning."""
        first_factor = self.gaps.size
        first_effect = first_factor + len(FACTORS)
        first_rest = first_effect + len(EFFECTS)
        effects = np.clip(vector[first_effect:first_rest], *EFFECT_LIMITS)
        # Cogging, which is largest at rest, too, is no friction of a motor that has next to none.
        excess, friction = EFFECTS.index("excess_voltage"), EFFECTS.index("friction_voltage")
        effects[excess] = min(effects[excess], MOST_EXCESS * effects[friction])
        # A fit that has made friction rigid would not find out that it yields.
        least = min(float(self.effects[YIELD_ANGLE]), SMALLEST_YIELD_ANGLE)
        effects[YIELD_ANGLE] = max(float(effects[YIELD_ANGLE]), least)
        # Nor would one that has made the voltage prompt find out that it is late.
        least = min(float(self.effects[VOLTAGE_LAG]), SMALLEST_LAG)
        effects[VOLTAGE_LAG] = max(float(effects[VOLTAGE_LAG]), least)
        initial_conditions = vector[first_rest:].reshape(self.initial_conditions.shape).copy()
        np.clip(initial_conditions[:, 0], -1.0, 1.0, out=initial_conditions[:, 0])
        return Unknowns(
            np.maximum(vector[:first_factor], 0.0),
            np.clip(vector[first_factor:first_effect], -1.0, 1.0),
            initial_conditions,
            effects,
        )
