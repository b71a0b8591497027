"""What is known of a machine's constants before a window is looked at.

Windows overlap, so what the last one has told is no independent knowledge. What a window has told
that ended before this one begins is: it may have become a little wrong since, and counts as that.
"""

from collections.abc import Collection, Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bdt_plant.elementary_functions import float_logarithm
from bdt_plant.friction import friction_voltage
from bdt_plant.motor import MotorParameters
from bdt_twin.fixed_order import solution
from bdt_twin.model_factors import FACTORS, ROOM

FloatArray = NDArray[np.float64]

COGGING_PARTS = ("cogging_sine", "cogging_cosine")
"""The two parts of a wave of the motor's angle."""
THREAD_PARTS = ("thread_sine", "thread_cosine")
"""The two parts of the error of the screw's thread, a wave of its angle."""
FRICTION_CHANGES = ("friction_growth", "friction_slope")
"""What Coulomb friction changes by, with time and along the screw."""


class Effect(NamedTuple):
    """What is known of an effect before, in its unit.

    Attributes
    ----------
    lowest, highest : float
        Its limits.
    spread : float
        Standard deviation on a machine that nobody has looked at.
    change_rate : float
        Random walk, in its unit per s^0.5.
    """

    lowest: float
    highest: float
    spread: float
    change_rate: float


_KNOWN = {
    # Voltage that Coulomb friction takes, that at the newest sample and at position zero [V].
    "friction_voltage": Effect(0.0, 100.0, 0.3, 5e-4),
    # Voltage that the amplifier adds [V].
    "voltage_offset": Effect(-10.0, 10.0, 0.05, 5e-4),
    # Age [s] and drift [m/s] of the readings.
    "delay": Effect(-0.1, 0.1, 5e-4, 5e-6),
    "drift": Effect(-1.0, 1.0, 1e-6, 1e-7),
    # How much more voltage friction takes at rest [V], and the natural logarithm of the Stribeck
    # speed over USUAL_STRIBECK_SPEED.
    "excess_voltage": Effect(0.0, 100.0, 0.2, 5e-4),
    "stribeck_speed": Effect(-1.5, 1.5, 0.5, 5e-3),
    # Voltage that the motor takes for the force with which the structure resists the screw [V/N].
    "load_voltage": Effect(0.0, 10.0, 5e-3, 5e-5),
    # Parts of the motor's cogging, as voltages against forward motion [V].
    **dict.fromkeys(COGGING_PARTS, Effect(-10.0, 10.0, 0.03, 1e-3)),
    # Share of Coulomb friction by which it changes in a second [1/s], and along the screw [1/m].
    "friction_growth": Effect(-0.1, 0.1, 5e-3, 2e-4),
    "friction_slope": Effect(-200.0, 200.0, 20.0, 0.2),
    # Angle by which friction yields before it slides [rad].
    "yield_angle": Effect(0.0, 0.1, 0.02, 1e-4),
    # Time constant with which the amplifier follows its command [s].
    "voltage_lag": Effect(0.0, 0.02, 2e-3, 5e-6),
    # Natural logarithm of the factor on the mass of platform 3, the last of MODEL_FACTORS.
    "top_mass": Effect(float_logarithm(ROOM[0]), float_logarithm(ROOM[1]), 0.3, 5e-4),
    # Parts of the error of the screw's thread [m].
    **dict.fromkeys(THREAD_PARTS, Effect(-1e-4, 1e-4, 5e-6, 1e-9)),
}
EFFECTS = tuple(_KNOWN)
"""What a machine has that the paper's mechanism has not."""
EFFECT_LIMITS = np.array(
    [[each.lowest for each in _KNOWN.values()], [each.highest for each in _KNOWN.values()]]
)
"""Smallest and largest values of ``EFFECTS``."""
EFFECT_SPREAD = tuple(each.spread for each in _KNOWN.values())
"""Standard deviations of ``EFFECTS`` of a machine that nobody has looked at."""
EFFECT_CHANGE_RATE = tuple(each.change_rate for each in _KNOWN.values())
"""Random walk of ``EFFECTS``, in their units per s^0.5."""

COGGING = frozenset(map(EFFECTS.index, COGGING_PARTS))
"""Places in ``EFFECTS`` of the parts of cogging."""

YIELD_ANGLE = EFFECTS.index("yield_angle")
"""Place in ``EFFECTS`` of the angle by which friction yields."""

VOLTAGE_LAG = EFFECTS.index("voltage_lag")
"""Place in ``EFFECTS`` of the time constant with which the amplifier follows its command."""

TOP_MASS = EFFECTS.index("top_mass")
"""Place in ``EFFECTS`` of the factor on the mass of the top platform."""

THREAD = frozenset(map(EFFECTS.index, THREAD_PARTS))
"""Places in ``EFFECTS`` of the parts of the thread's error."""

USUAL_STRIBECK_SPEED = 2.0
"""Stribeck speed of a motor that nobody has looked at [rad/s]."""

FACTOR_SPREAD = (0.3, 0.2, 0.7)
"""Standard deviations of the logarithms of ``FACTORS`` of such a machine."""
FACTOR_CHANGE_RATE = (5e-4, 5e-4, 5e-3)
"""Random walk of the logarithms of ``FACTORS`` [1/s^0.5]."""
ABSENT = 1e-6
"""Share of its spread that an effect may have as long as there is no evidence of it."""
CHANGING = ("friction_voltage", "friction_growth")
"""Friction, and what it changes by in a second."""
LONGEST_TREND = 60.0
"""Time [s] beyond which friction that has changed is not thought to go on with that."""
LEAST_GROWN = 0.1
"""Least share of the doubt about friction that stays, whatever it may have become: of friction that
has come to nothing its change alone would tell, and exactly."""
DOUBT = 2.0
"""Factor by which what a window has told is less sure than it has said."""


class MachineKnowledge(NamedTuple):
    """Knowledge of ``FACTORS`` (their logarithms) and ``EFFECTS``, in this order.

    Attributes
    ----------
    expected : ndarray, shape (constants,)
        Expected values.
    covariance : ndarray, shape (constants, constants)
        Their covariance.
    """

    expected: FloatArray
    covariance: FloatArray

    def bounded(self, first: "MachineKnowledge") -> "MachineKnowledge":
        """Return the knowledge with no constant less sure than in what was known at `first`."""
        spread = np.sqrt(np.diag(self.covariance))
        share = np.minimum(np.sqrt(np.diag(first.covariance)) / spread, 1.0)
        return self._replace(covariance=self.covariance * np.outer(share, share))

    def without(self, absent: Iterable[int]) -> "MachineKnowledge":
        """Return the knowledge of a machine that has not these places of ``EFFECTS``."""
        return self._with_spread(absent, ABSENT)

    def forgetting(self, effects: Collection[int]) -> "MachineKnowledge":
        """Return the knowledge without any of these places of ``EFFECTS``, expected to be zero."""
        expected = self.expected.copy()
        expected[[len(FACTORS) + effect for effect in effects]] = 0.0
        return self._replace(expected=expected)._with_spread(effects, 1.0)

    def _with_spread(self, effects: Iterable[int], share: float) -> "MachineKnowledge":
        covariance = self.covariance.copy()
        for effect in effects:
            place = len(FACTORS) + effect
            covariance[place, :] = covariance[:, place] = 0.0
            covariance[place, place] = np.square(share * EFFECT_SPREAD[effect])
        return self._replace(covariance=covariance)

    def precision(self) -> FloatArray:
        """Return the inverse covariance, shape (constants, constants)."""
        scale = 1.0 / np.sqrt(np.diag(self.covariance))
        scaled = self.covariance * np.outer(scale, scale)
        return solution(scaled, np.eye(scale.size)) * np.outer(scale, scale)

    def aged(self, time: float) -> "MachineKnowledge":
        """Return what is left of the knowledge some time [s] later."""
        change = np.square((*FACTOR_CHANGE_RATE, *EFFECT_CHANGE_RATE)) * max(time, 0.0)
        return self._replace(covariance=DOUBT * DOUBT * self.covariance + np.diag(change))

    def projected(self, time: float) -> "MachineKnowledge":
        """Return the knowledge of a machine whose friction went on changing for some time [s]."""
        friction, growth = (len(FACTORS) + EFFECTS.index(name) for name in CHANGING)
        expected, covariance = self.expected.copy(), self.covariance.copy()
        grown = grown_friction(float(expected[growth]), time)
        per_growth = _trend(time) * float(expected[friction])
        expected[friction] *= grown
        grown = max(grown, LEAST_GROWN)
        covariance[friction] = grown * covariance[friction] + per_growth * covariance[growth]
        covariance[:, friction] = (
            grown * covariance[:, friction] + per_growth * covariance[:, growth]
        )
        return MachineKnowledge(expected, covariance)


def grown_friction(growth: float, time: float) -> float:
    """Return what friction has become after some time, over what it was.

    Parameters
    ----------
    growth : float
        Share of it that comes in a second [1/s].
    time : float
        Time [s]; what is beyond ``LONGEST_TREND`` does not count.
    """
    return max(1.0 + growth * _trend(time), 0.0)


def _trend(time: float) -> float:
    """Return for how much of some time [s] friction goes on changing."""
    return min(max(time, 0.0), LONGEST_TREND)


def first_knowledge(motor: MotorParameters) -> MachineKnowledge:
    """Return what is known of a machine from its model alone."""
    return independent_knowledge(friction_voltage(motor), (*FACTOR_SPREAD, *EFFECT_SPREAD))


def independent_knowledge(friction: float, spread: Sequence[float]) -> MachineKnowledge:
    """Return knowledge in which no constant tells anything about another one.

    Parameters
    ----------
    friction : float
        Expected voltage of the friction [V]; all others are expected to be zero.
    spread : sequence of float
        Standard deviations of the logarithms of ``FACTORS`` and of ``EFFECTS``.
    """
    expected = np.zeros(len(FACTORS) + len(EFFECTS))
    expected[len(FACTORS) + EFFECTS.index("friction_voltage")] = friction
    return MachineKnowledge(expected, np.diag(np.square(spread)))
