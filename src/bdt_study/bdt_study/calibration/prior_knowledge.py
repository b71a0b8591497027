"""What is known of a machine before its telemetry is looked at: hardly more than the magnitude."""

from collections.abc import Collection

import numpy as np

from bdt_twin.fit_result import Fit
from bdt_twin.machine_knowledge import (
    COGGING_PARTS,
    EFFECTS,
    FRICTION_CHANGES,
    THREAD_PARTS,
    MachineKnowledge,
    independent_knowledge,
)
from bdt_twin.machine_knowledge import EFFECT_SPREAD as TWIN_SPREAD
from bdt_twin.model_factors import FACTORS
from bdt_twin.noise_levels import SMALLEST_NOISE

FACTOR_SPREAD = (0.7, 0.7, 0.7)
"""Prior standard deviations of the logarithms of ``FACTORS``: twice as large, or half."""
CALIBRATED_EFFECTS = ("friction_voltage", "voltage_offset", "delay", "drift")
"""Those of ``EFFECTS`` that every calibration looks for, the first ones."""
JOINING_EFFECTS = (
    ("excess_voltage", "stribeck_speed", "load_voltage"),
    COGGING_PARTS,
    FRICTION_CHANGES,
    ("yield_angle",),
    ("top_mass",),
    THREAD_PARTS,
)
"""Those that one looks for if windows of the data give evidence of one of their group."""
_EFFECT_SPREAD = {
    "friction_voltage": 1.0,
    "voltage_offset": 0.2,
    "delay": 2e-3,
    "drift": 1e-5,
    "excess_voltage": 0.5,
    **dict.fromkeys(COGGING_PARTS, 0.1),
    "top_mass": 0.5,
    **dict.fromkeys(THREAD_PARTS, 1e-5),
}
EFFECT_SPREAD = tuple(
    _EFFECT_SPREAD.get(name, spread) for name, spread in zip(EFFECTS, TWIN_SPREAD, strict=True)
)
"""Prior standard deviations of ``EFFECTS``: those of the twin, or larger ones."""
_ABSENT = 1e-9
_HELD = (1e-7, 1e-7, 1e-7, 1e-7, 1e-7, 1e-9, 1e-12)
HELD_SPREAD = (*_HELD, *(_ABSENT,) * (len(FACTORS) + len(EFFECTS) - len(_HELD)))
"""Standard deviations of ``FACTORS`` and ``EFFECTS`` that stay what they are."""
PLAUSIBLE = 4.0
"""Standard deviations of the prior within which a machine is one."""
UNTOLD = 1e-9
"""Standard deviation of an effect that is not looked for yet."""


def wide_knowledge(friction: float, joining: Collection[str] = ()) -> MachineKnowledge:
    """Return a prior that hardly says more than the order of magnitude.

    Parameters
    ----------
    friction : float
        Expected voltage of the friction [V].
    joining : collection of str
        Effects beside ``CALIBRATED_EFFECTS`` that the machine has.
    """
    spread = [
        size if name in (*CALIBRATED_EFFECTS, *joining) else _ABSENT
        for name, size in zip(EFFECTS, EFFECT_SPREAD, strict=True)
    ]
    return independent_knowledge(friction, (*FACTOR_SPREAD, *spread))


def without_late_readings(knowledge: MachineKnowledge) -> MachineKnowledge:
    """Return a prior that holds delay and drift: at reversals a gap is like a late reading."""
    spread = np.diag(knowledge.covariance).copy()
    spread[[len(FACTORS) + EFFECTS.index(name) for name in ("delay", "drift")]] = UNTOLD**2
    return knowledge._replace(covariance=np.diag(spread))


def is_plausible(fit: Fit, knowledge: MachineKnowledge) -> bool:
    """Tell whether a machine is what the prior allows, and not all of it noise of the machine."""
    off = np.abs(fit.machine.expected - knowledge.expected)
    spread = np.sqrt(np.diag(knowledge.covariance))
    return bool((off <= PLAUSIBLE * spread).all()) and fit.levels.reading > 2.0 * SMALLEST_NOISE
